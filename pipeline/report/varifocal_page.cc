#include "pipeline/report/varifocal_page.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pipeline/report/calibration_figures.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/plane_figures.h"

namespace lamella {
namespace {

// By what each is known to.
std::size_t WorstPlane(const VarifocalReport& report, double CalibratedPlane::*deviation) {
  const auto worst = std::max_element(report.planes.begin(), report.planes.end(),
                                      [&](const CalibratedPlane& a, const CalibratedPlane& b) {
                                        return a.*deviation < b.*deviation;
                                      });
  return static_cast<std::size_t>(worst - report.planes.begin());
}

std::string PlanesVerdict(const VarifocalReport& report) {
  std::vector<std::pair<std::string, std::string>> facts;
  if (report.covariance.size() == 0) {
    facts.emplace_back("Planes", "no number: some parameters are unknown");
  } else {
    const std::size_t deep = WorstPlane(report, &CalibratedPlane::depth_sd_mm);
    const std::size_t large = WorstPlane(report, &CalibratedPlane::magnification_sd);
    facts.emplace_back(
        "Depths are known to",
        fmt::format("{:.4f} mm at worst (plane {}), {} mm asked for",
                    report.planes[deep].depth_sd_mm, deep, report.limits.largest_depth_sd_mm));
    facts.emplace_back("Magnifications are known to",
                       fmt::format("{:.1e} at worst (plane {}), {:.0e} asked for",
                                   report.planes[large].magnification_sd, large,
                                   report.limits.largest_magnification_sd));
    facts.emplace_back("Rays are known to",
                       fmt::format("{:.4f} px RMS, {:.4f} px at worst", report.rays.rms_sd_px,
                                   report.rays.max_sd_px));
    facts.emplace_back("The mirror", Describe(report.mirror));
  }
  facts.emplace_back("Positions span", fmt::format("{:.1f} degrees", report.view_angles_deg));
  facts.emplace_back("Chi squared per degree of freedom", fmt::format("{:.3f}", report.chi2));
  facts.emplace_back("Photographs of one position shift by",
                     fmt::format("{:.4f} px", report.slip_px));
  return PageVerdict(report.accepted(), facts);
}

std::string PlanesDirections(const VarifocalReport& report) {
  const std::vector<int> of_planes = Pooled(report.residuals).views;
  std::vector<CameraDirection> cameras;
  for (std::size_t i = 0; i < report.camera_from_display.size(); ++i) {
    const std::string& name = report.views_fit[i].name;  // "view 3"
    const bool is_of_planes =
        std::binary_search(of_planes.begin(), of_planes.end(), static_cast<int>(i));
    cameras.push_back({DirectionTo(Centre(report.camera_from_display[i])),
                       name.substr(name.find(' ') + 1), !is_of_planes});
  }
  std::optional<Eigen::Vector2d> next;
  if (report.next_view) next = {report.next_view->right_deg, report.next_view->up_deg};
  return DirectionFigure(cameras, report.limits.eye_box, next);
}

std::string PlanesViews(const VarifocalReport& report) {
  const std::string next = DescribeNextPlaneView(report);
  return PageSection(
      "Camera positions",
      PageNote(fmt::format(
          "Cameras by their number, in degrees from the display's normal (hollow: no plane is seen "
          "from there); dashed: where eyes are. What tells a plane's depth from its magnification "
          "is the angle between positions, {:.1f} degrees at most. Orange ring: {}. Chi squared is "
          "in the mean of the planes'.",
          report.view_angles_deg,
          next.empty() ? "none, no place shows all planes at once"
                       : "the photographs that would help most, " + next)) +
          PageDrawings({{"Directions", PlanesDirections(report)},
                        {"Chi squared of views",
                         Chi2Figure(InTheMean(report.views_fit, report.planes_fit))}}));
}

// A number of every plane.
template <class Number>
PlaneSeries SeriesOf(const VarifocalReport& report, const char* label, const char* unit,
                     const Number& number) {
  PlaneSeries series{label, unit, {}, {}};
  for (std::size_t i = 0; i < report.planes.size(); ++i) series.values.push_back(number(i));
  return series;
}

std::string PlaneFigures(const SolvedVarifocal& solved) {
  const VarifocalReport& report = solved.report;
  const std::vector<CalibratedPlane>& planes = report.planes;
  const Calibration design = DesignCalibration(solved.display);
  PlaneSeries depths =
      SeriesOf(report, "Depth less the designed one, mm", "mm", [&](std::size_t i) {
        return planes[i].display_from_plane.translation.z() -
               design.layers[i].display_from_stack.translation.z();
      });
  PlaneSeries sizes = SeriesOf(
      report, "Magnification less the designed one", "",
      [&](std::size_t i) { return planes[i].magnification - 1 - design.layers[i].emitter.scale; });
  const PlaneSeries depth_sds = SeriesOf(report, "Standard deviation of depth, mm", "mm",
                                         [&](std::size_t i) { return planes[i].depth_sd_mm; });
  const PlaneSeries size_sds = SeriesOf(report, "Standard deviation of magnification", "",
                                        [&](std::size_t i) { return planes[i].magnification_sd; });
  depths.sds = depth_sds.values;
  sizes.sds = size_sds.values;
  std::vector<CaptionedDrawing> drawings = {
      {depths.label, PlaneLineFigure(depths)},
      {sizes.label, PlaneLineFigure(sizes)},
      {depth_sds.label, PlaneColumnFigure(depth_sds, 0, report.limits.largest_depth_sd_mm)},
      {size_sds.label, PlaneColumnFigure(size_sds, 0, report.limits.largest_magnification_sd)}};
  if (report.mirror.tested) {
    PlaneSeries off = SeriesOf(report, "Depth less the mirror's model, mm", "mm",
                               [&](std::size_t i) { return report.mirror.deviations[i](5); });
    off.sds = depth_sds.values;
    drawings.push_back({off.label, PlaneLineFigure(off)});
  }
  const std::vector<FitOf> fits = InTheMean(report.planes_fit, report.planes_fit);
  const PlaneSeries chi2 = SeriesOf(report, "Chi squared of planes, in their mean", "",
                                    [&](std::size_t i) { return fits[i].chi2; });
  drawings.push_back({chi2.label, PlaneColumnFigure(chi2, kLeastChi2Drawn, kMostChi2Drawn)});
  return PageSection("Planes",
                     PageNote("Planes from the back (0) to the front. Upright lines: one standard "
                              "deviation to either side. Dashed: what is asked for; columns beyond "
                              "it are orange.") +
                         PageDrawings(drawings));
}

std::string PlaneMaps(const VarifocalReport& report) {
  std::vector<CaptionedDrawing> drawings = {
      {fmt::format("Residuals, of {} planes together", report.planes.size()),
       ResidualFigure("Residuals of planes", Pooled(report.residuals), kLargestMeanPx)}};
  if (!report.rays.sd_px.empty()) {
    const std::vector<PlaceDeviation> places = DeviationsOf(report.probed, report.rays);
    double most = 0;
    for (const PlaceDeviation& place : places) most = std::max(most, place.rms_px);
    drawings.push_back(
        {"Standard deviation of rays, px, of all planes and eyes",
         DeviationFigure("Standard deviation of rays through planes, px", 7, places, most)});
  }
  const EyeBox& box = report.limits.eye_box;
  return PageSection(
      "Where on the planes",
      PageNote(fmt::format(
          "A plane's panel as it is given its image. Residuals: numbers, and darker cells: points "
          "of all planes; lines: the mean of seen minus predicted, in the panel's pixels; 0.03 px "
          "would reach nearly to the cell's edge, and more than that and chance is orange. Rays: "
          "the pixel that an eye within {:.0f} x {:.0f} mm, {:.0f} to {:.0f} mm away, sees there; "
          "RMS, darkest where it is most.",
          2 * box.half_width_mm, 2 * box.half_height_mm, box.near_mm, box.far_mm)) +
          PageDrawings(drawings));
}

std::string PlaneTable(const VarifocalReport& report) {
  constexpr double kDegreesOfTurn = 180 / std::numbers::pi;
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < report.planes.size(); ++i) {
    const CalibratedPlane& plane = report.planes[i];
    const ResidualMap& map = report.residuals[i];
    const Eigen::AngleAxisd turn(plane.display_from_plane.rotation);
    const Eigen::Vector3d tilt = kDegreesOfTurn * turn.angle() * turn.axis();
    rows.push_back(
        {fmt::format("{}", i),
         fmt::format("{:.4f} ± {:.4f}", plane.display_from_plane.translation.z(),
                     plane.depth_sd_mm),
         fmt::format("{:.6f} ± {:.6f}", plane.magnification, plane.magnification_sd),
         fmt::format("{:.4f}", tilt.x()),
         fmt::format("{:.4f} ± {:.4f}", tilt.y(), kDegreesOfTurn * plane.tilt_sd_rad),
         fmt::format("{:.4f}", tilt.z()), fmt::format("{}", map.views.size()),
         fmt::format("{} of {}", report.planes_fit[i].num_used, report.planes_fit[i].num_points)});
  }
  return PageSection("Parameters",
                     HtmlTable({"plane", "depth, mm", "magnification", "tilt x, degrees", "tilt y",
                                "rotation", "views", "points"},
                               rows));
}

}  // namespace

std::string VarifocalPage(const SolvedVarifocal& solved) {
  const VarifocalReport& report = solved.report;
  return CalibrationHtml(
      solved.display.name, solved.photos.size(),
      PlanesVerdict(report) + PageWeaknesses("What the photographs leave open", report.failures) +
          PageWeaknesses("What is weak", report.warnings) + PlanesViews(report) +
          PlaneFigures(solved) + PlaneMaps(report) + PageLines("Left out", solved.left_out) +
          PageLines("Used, though better ones would help", solved.doubtful) +
          PageGroups("Parameters beyond poses and magnifications", report.groups) +
          PlaneTable(report));
}

}  // namespace lamella
