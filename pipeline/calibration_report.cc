#include "pipeline/calibration_report.h"

#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace lamella {
namespace {

void AddWeaknesses(const char* title, const std::vector<Weakness>& weaknesses, std::string& text) {
  if (weaknesses.empty()) return;
  text += fmt::format("\n{}\n", title);
  for (const Weakness& weakness : weaknesses) {
    text += fmt::format("  {}\n    cure: {}\n", weakness.lost, weakness.cure);
  }
}

void AddFits(const char* title, const std::vector<FitOf>& fits, std::string& text) {
  text += fmt::format("\n{}: points used, of all, RMS px, chi^2 per degree of freedom\n", title);
  for (const FitOf& fit : fits) {
    text += fmt::format("  {:<20} {:>6} {:>6} {:>8.4f} {:>7.3f}\n", fit.name, fit.num_used,
                        fit.num_points, fit.rms_px, fit.chi2);
  }
}

void AddLayers(const Calibration& calibration, std::string& text) {
  text += "\nlayers: offset x, y and gap (mm), tilt x, tilt y and rotation (degrees)\n";
  for (std::size_t i = 0; i < calibration.layers.size(); ++i) {
    const LayerCalibration& layer = calibration.layers[i];
    const Eigen::Vector3d degrees = layer.rotation_rad * (180 / std::numbers::pi);
    text += fmt::format("  layer {} {:>10.4f} {:>9.4f} {:>9.4f} {:>10.5f} {:>9.5f} {:>9.5f}\n", i,
                        layer.offset_mm.x(), layer.offset_mm.y(), layer.gap_mm, degrees.x(),
                        degrees.y(), degrees.z());
  }
}

}  // namespace

std::string DescribeCalibration(const CalibrationReport& report) {
  std::string text = report.accepted() ? "the calibration is certain enough\n"
                                       : "the calibration is NOT certain\n";
  text += fmt::format(
      "rays are known to {:.4f} px RMS and {:.4f} px at worst ({}); reference: {}; chi^2 {:.3f}; "
      "photographs of one position shift by {:.4f} px\n",
      report.rays.rms_sd_px, report.rays.max_sd_px, NameOf(report.rays.worst.panel),
      NameOf(report.reference), report.chi2, report.slip_px);
  AddWeaknesses("what the photographs leave open", report.failures, text);
  AddWeaknesses("what is weak", report.warnings, text);
  if (!report.rejected.empty()) text += "\nleft out\n";
  for (const std::string& line : report.rejected) text += fmt::format("  {}\n", line);
  AddLayers(report.calibration, text);
  AddFits("panels", report.panels, text);
  AddFits("views", report.views_fit, text);
  text += "\nparameters beyond poses and gaps\n";
  for (const GroupVerdict& verdict : report.groups) {
    text += fmt::format("  {}: {}: {}\n", verdict.group, verdict.freed ? "freed" : "as designed",
                        verdict.reason);
  }
  return text;
}

}  // namespace lamella
