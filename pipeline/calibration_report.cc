#include "pipeline/calibration_report.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace lamella {
namespace {

void AddFits(const char* title, const std::vector<FitOf>& fits, std::string& text) {
  text += fmt::format("\n{}: points used, of all, RMS px, chi^2 per degree of freedom\n", title);
  for (const FitOf& fit : fits) {
    text += fmt::format("  {:<20} {:>6} {:>6} {:>8.4f} {:>7.3f}\n", fit.name, fit.num_used,
                        fit.num_points, fit.rms_px, fit.chi2);
  }
}

// "0.0123 +- 0.0004", or the number alone where it was not estimated.
std::string WithDeviation(double value, double factor, int digits, const std::string& name,
                          const CalibrationReport& report) {
  for (const ParameterDeviation& deviation : report.deviations) {
    if (deviation.name != name) continue;
    return fmt::format("{:.{}f} +- {:.{}f}", value * factor, digits, deviation.sd * factor, digits);
  }
  return fmt::format("{:.{}f}", value * factor, digits);
}

void AddLayers(const CalibrationReport& report, std::string& text) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  text += "\nemitters in their layers, with standard deviations\n";
  for (std::size_t i = 0; i < report.calibration.layers.size(); ++i) {
    const LayerCalibration& layer = report.calibration.layers[i];
    if (!layer.modulator) continue;
    const std::string name = fmt::format("layer {}", i);
    const auto number = [&](double value, double factor, int digits, const char* what) {
      return WithDeviation(value, factor, digits, name + " " + what, report);
    };
    text += fmt::format("  {}: offset x {} mm, offset y {} mm, gap {} mm\n", name,
                        number(layer.offset_mm.x(), 1, 4, "offset x"),
                        number(layer.offset_mm.y(), 1, 4, "offset y"),
                        number(layer.gap_mm, 1, 4, "gap"));
    text += fmt::format("           tilt x {}, tilt y {}, rotation {} degrees\n",
                        number(layer.rotation_rad.x(), kDegrees, 5, "tilt x"),
                        number(layer.rotation_rad.y(), kDegrees, 5, "tilt y"),
                        number(layer.rotation_rad.z(), kDegrees, 5, "rotation"));
  }
}

std::string Rays(const CalibrationReport& report) {
  if (report.rays.sd_px.empty()) return "how well rays are known has no number: some are not";
  return fmt::format("rays are known to {:.4f} px RMS and {:.4f} px at worst ({})",
                     report.rays.rms_sd_px, report.rays.max_sd_px, NameOf(report.rays.worst.panel));
}

}  // namespace

std::string DescribeWeaknesses(const char* title, const std::vector<Weakness>& weaknesses) {
  if (weaknesses.empty()) return "";
  std::string text = fmt::format("\n{}\n", title);
  for (const Weakness& weakness : weaknesses) {
    text += fmt::format("  {}\n    cure: {}\n", weakness.lost, weakness.cure);
  }
  return text;
}

std::string DescribeLines(const char* title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string text = fmt::format("\n{}\n", title);
  for (const std::string& line : lines) text += fmt::format("  {}\n", line);
  return text;
}

std::string DescribePlace(double right_deg, double up_deg, double distance_mm) {
  const auto side = [](double degrees, const char* positive, const char* negative) {
    return fmt::format("{:.0f} degrees {}", std::abs(degrees), degrees < 0 ? negative : positive);
  };
  std::string place = "straight in front";
  if (right_deg != 0) place = side(right_deg, "to the right", "to the left");
  if (up_deg != 0) {
    place = (right_deg != 0 ? place + " and " : std::string()) + side(up_deg, "above", "below");
  }
  return fmt::format("{}, {:.0f} mm away", place, distance_mm);
}

std::string DescribeNextView(const CalibrationReport& report) {
  if (!report.next_view) return "";
  const NextView& next = *report.next_view;
  return fmt::format("all panels from {}, after which rays would be known to {:.4f} px RMS",
                     DescribePlace(next.right_deg, next.up_deg, next.distance_mm),
                     next.next_rms_sd_px);
}

std::string DescribeCalibration(const SolvedPhotos& solved) {
  const CalibrationReport& report = solved.report;
  std::string text = fmt::format(
      "{}: the calibration is {}\n{}; the unit of length is the pitch of {}; chi^2 per degree of "
      "freedom {:.3f}; photographs of one position shift by {:.4f} px\n",
      solved.display.name, report.accepted() ? "certain enough" : "NOT certain", Rays(report),
      NameOf(report.reference), report.chi2, report.slip_px);
  text += DescribeWeaknesses("what the photographs leave open", report.failures);
  text += DescribeWeaknesses("what is weak", report.warnings);
  const std::string next = DescribeNextView(report);
  if (!next.empty()) text += "\nthe next photographs that help most\n  " + next + "\n";
  text += DescribeLines("left out", solved.left_out);
  text += DescribeLines("used, though better ones would help", solved.doubtful);
  AddLayers(report, text);
  AddFits("panels", report.panels, text);
  AddFits("views (camera positions)", report.views_fit, text);
  text += "\nparameters beyond poses and gaps\n";
  for (const GroupVerdict& verdict : report.groups) {
    text += fmt::format("  {}: {}: {}\n", verdict.group, verdict.freed ? "freed" : "as designed",
                        verdict.reason);
  }
  return text;
}

}  // namespace lamella
