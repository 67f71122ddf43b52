#include "pipeline/report/calibration_page.h"

#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pipeline/calibration_report.h"
#include "pipeline/report/calibration_figures.h"
#include "pipeline/report/page_parts.h"

namespace lamella {
namespace {

std::string PanelsVerdict(const CalibrationReport& report) {
  std::vector<std::pair<std::string, std::string>> facts;
  if (report.rays.sd_px.empty()) {
    facts.emplace_back("Rays", "no number: some parameters are unknown");
  } else {
    facts.emplace_back(
        "Rays are known to",
        fmt::format("{:.4f} px RMS ({} asked for), {:.4f} px at worst ({} asked for)",
                    report.rays.rms_sd_px, report.limits.largest_ray_rms_px, report.rays.max_sd_px,
                    report.limits.largest_ray_max_px));
  }
  facts.emplace_back("Chi squared per degree of freedom", fmt::format("{:.3f}", report.chi2));
  facts.emplace_back("Photographs of one position shift by",
                     fmt::format("{:.4f} px", report.slip_px));
  facts.emplace_back("The unit of length is the pitch of", NameOf(report.reference));
  return PageVerdict(report.accepted(), facts);
}

std::string PanelsRays(const CalibrationReport& report) {
  if (report.rays.sd_px.empty()) return "";
  std::vector<CaptionedDrawing> drawings;
  for (const ResidualMap& map : report.residuals) {
    if (map.panel == report.reference) continue;
    const std::string name = NameOf(map.panel);
    drawings.push_back(
        {name, DeviationFigure("Standard deviation of rays that meet " + name + ", px", 7,
                               DeviationsOf(report.probed, report.rays, map.panel),
                               report.limits.largest_ray_rms_px)});
  }
  const EyeBox& box = report.limits.eye_box;
  return PageSection(
      "How well rays are known",
      PageNote(fmt::format(
          "Standard deviation, px of each panel, of the pixel that an eye sees behind "
          "or before a place of {} (as seen from the front); RMS over eyes within {:.0f} "
          "x {:.0f} mm, {:.0f} to {:.0f} mm away. Orange: more than is asked for.",
          NameOf(report.reference), 2 * box.half_width_mm, 2 * box.half_height_mm, box.near_mm,
          box.far_mm)) +
          PageDrawings(drawings));
}

std::string PanelsResiduals(const CalibrationReport& report) {
  std::vector<CaptionedDrawing> drawings;
  for (const ResidualMap& map : report.residuals) {
    const std::string name = NameOf(map.panel);
    drawings.push_back({fmt::format("{}, in {} views", name, map.views.size()),
                        ResidualFigure("Residuals of " + name, map, kLargestMeanPx)});
  }
  return PageSection(
      "Where points were seen, and where they should have been",
      PageNote("Each panel as it is given its image. Numbers, and darker cells: points. Lines: the "
               "mean of seen minus predicted, in the panel's pixels; 0.03 px would reach nearly to "
               "the cell's edge, and more than that and chance is orange. Means that follow a "
               "pattern are a shape that is not modelled.") +
          PageDrawings(drawings));
}

// As the reference stack sees cameras.
std::string PanelsDirections(const CalibrationReport& report) {
  const auto layer = static_cast<std::size_t>(report.reference.layer);
  const Rigid stack_from_display = Inverse(report.calibration.layers[layer].display_from_stack);
  std::vector<CameraDirection> cameras;
  for (std::size_t i = 0; i < report.camera_from_display.size(); ++i) {
    cameras.push_back({DirectionTo(stack_from_display * Centre(report.camera_from_display[i])),
                       fmt::format("{}", report.views[i] + 1)});
  }
  std::optional<Eigen::Vector2d> next;
  if (report.next_view) next = {report.next_view->right_deg, report.next_view->up_deg};
  return DirectionFigure(cameras, report.limits.eye_box, next);
}

std::string PanelsViews(const CalibrationReport& report) {
  std::string note =
      "Left: cameras by their number, in degrees from the normal of the reference panel; dashed: "
      "where eyes are; orange ring: ";
  const std::string next = DescribeNextView(report);
  note += next.empty() ? "none, no place shows all panels at once."
                       : "the photographs that would help most, " + next + ".";
  note += " Chi squared is in the mean of the panels'.";
  return PageSection(
      "Camera positions",
      PageNote(note) +
          PageDrawings(
              {{"Directions", PanelsDirections(report)},
               {"Chi squared of views", Chi2Figure(InTheMean(report.views_fit, report.panels))},
               {"Chi squared of panels", Chi2Figure(InTheMean(report.panels, report.panels))}}));
}

std::string PanelsDeviations(const CalibrationReport& report) {
  if (report.deviations.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const ParameterDeviation& deviation : report.deviations) {
    rows.push_back({deviation.name, fmt::format("{:.3g} {}", deviation.sd, deviation.unit)});
  }
  return PageSection("Standard deviations", HtmlTable({"parameter", "deviation"}, rows));
}

}  // namespace

std::string CalibrationPage(const SolvedPhotos& solved) {
  const CalibrationReport& report = solved.report;
  return CalibrationHtml(
      solved.display.name, solved.photos.size(),
      PanelsVerdict(report) + PageWeaknesses("What the photographs leave open", report.failures) +
          PageWeaknesses("What is weak", report.warnings) + PanelsViews(report) +
          PanelsRays(report) + PanelsResiduals(report) + PageLines("Left out", solved.left_out) +
          PageLines("Used, though better ones would help", solved.doubtful) +
          PageGroups("Parameters beyond poses and gaps", report.groups) + PanelsDeviations(report));
}

}  // namespace lamella
