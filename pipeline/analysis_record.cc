#include "pipeline/analysis_record.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/bandwidth.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/depth_record.h"
#include "pipeline/layers_record.h"
#include "pipeline/poses_record.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kAnalysisVersion = 1;

// JSON has no infinity.
Json FiniteOrName(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

Json ToJson(const EyeRectangle& box) {
  return {{"x", FiniteOrName(box.x_mm)}, {"y", FiniteOrName(box.y_mm)}};
}

Json ToJson(const LayerFigures& f) {
  return {{"position_mm", f.position_mm},
          {"d0_mm", f.d0_mm},
          {"lattice_pitch_mm", f.lattice_pitch_mm},
          {"direction_step_mm", f.direction_step_mm},
          {"sharp_range_mm", f.sharp_range_mm},
          {"sharpest_mm", f.sharpest_mm},
          {"field_of_view_deg", f.field_of_view_deg},
          {"directions_per_axis", f.directions_per_axis},
          {"view_spacing_mm", f.view_spacing_mm},
          {"light_efficiency", f.light_efficiency},
          {"guard_share", f.guard_share},
          {"rays", std::round(f.rays)},
          {"clean_eye_box_mm", ToJson(f.clean_eye_box)}};
}

Json ToJson(const MtfRows& rows) {
  Json json = {{"single", rows.single}, {"both", rows.both}};
  json["fixed_eye"] = rows.fixed_eye.empty() ? Json() : Json(rows.fixed_eye);
  return json;
}

Json ToJson(const SceneAnalysis& scene) {
  const SceneFigures& f = scene.figures;
  return {{"reference_view", scene.reference_view},
          {"placed_for", scene.placed_for},
          {"viewing_distance_mm", scene.viewing_distance_mm},
          {"known_share", f.known_share},
          {"far_mm", FiniteOrName(f.far_mm)},
          {"near_mm", FiniteOrName(f.near_mm)},
          {"sharp_share", f.sharp_share},
          {"detail_kept", f.detail_kept ? Json(*f.detail_kept) : Json()},
          {"detail_kept_beam", f.detail_kept_beam ? Json(*f.detail_kept_beam) : Json()},
          {"histogram",
           {{"edges_mm", f.edges_mm},
            {"share", f.share},
            {"share_behind", f.share_behind},
            {"share_before", f.share_before}}}};
}

Json RayLaw(const Analysis& analysis) {
  const int layers = static_cast<int>(analysis.layers.size());
  return {{"to_one_layer", analysis.rays_to_one_layer ? Json(*analysis.rays_to_one_layer) : Json()},
          {"shared_evenly", RayRatio(layers, analysis.parallax_axes)},
          {"full_parallax", RayRatio(layers, 2)},
          {"horizontal_parallax", RayRatio(layers, 1)}};
}

}  // namespace

DepthInterval SceneDepths(const Workspace& workspace) {
  const Placement placement = LoadLayersRecord(workspace).placement;
  return {std::min(placement.far_mm, placement.near_mm),
          std::max(placement.far_mm, placement.near_mm)};
}

DepthInterval DepthsFor(const Display& display, const DepthInterval& scene) {
  DepthInterval depths = DepthsWorthALook(display);
  const double length = depths.to_mm - depths.from_mm;
  depths.from_mm = std::min(depths.from_mm, std::max(scene.from_mm, depths.from_mm - length));
  depths.to_mm = std::max(depths.to_mm, std::min(scene.to_mm, depths.to_mm + length));
  return depths;
}

SceneAnalysis AnalyzeWorkspace(const Workspace& workspace, const Display& display,
                               const Analysis& analysis) {
  const LayersRecord record = LoadLayersRecord(workspace);
  const Placement& placement = record.placement;
  const ViewSet set = LoadViewSet(workspace);
  const auto view = std::find_if(set.views.begin(), set.views.end(),
                                 [&](const View& v) { return v.name == placement.reference_view; });
  if (view == set.views.end()) {
    throw InputError(
        (workspace.Stage("layers") / "layers.json").string(),
        fmt::format("names the view \"{}\", which the poses have not", placement.reference_view),
        "run `lamella layers` again");
  }
  const Image<Rgb> picture = workspace.photographs().Linear(view->image);
  const DepthMap map = LoadDepthMap(workspace.Stage("depth") / (view->name + ".exr"));
  return {placement.reference_view, record.display.name, placement.viewing_distance_mm,
          AnalyzeScene(display, analysis, placement, picture.span(), map.depth.span())};
}

std::string AnalysisJson(const Display& display, const Analysis& analysis,
                         const std::optional<SceneAnalysis>& scene) {
  Json layers = Json::array();
  for (const LayerFigures& layer : analysis.layers) layers.push_back(ToJson(layer));
  Json sharp = Json::array();
  for (const DepthInterval& interval : analysis.sharp) {
    sharp.push_back({interval.from_mm, interval.to_mm});
  }
  Json json = {{"format_version", kAnalysisVersion},
               {"display", display.name},
               {"viewing_distance_mm", display.viewing_distance_mm},
               {"parallax_axes", analysis.parallax_axes},
               {"layers", layers},
               {"rays", std::round(analysis.totals.rays)},
               {"bits", analysis.totals.bits},
               {"light_efficiency", analysis.totals.light_efficiency},
               {"rays_ratio", RayLaw(analysis)},
               {"sharp_mm", sharp},
               {"clean_eye_box_mm", ToJson(analysis.clean_eye_box)},
               {"depths_mm", analysis.depths_mm},
               {"cutoff_per_mm",
                {{"layers", analysis.cutoff},
                 {"combined", analysis.combined},
                 {"combined_beam", analysis.combined_beam}}},
               {"mtf",
                {{"frequencies_per_mm", analysis.frequencies},
                 {"own", ToJson(analysis.mtf)},
                 {"paper", ToJson(analysis.paper_mtf)}}}};
  if (scene) json["scene"] = ToJson(*scene);
  return json.dump(1) + "\n";
}

}  // namespace lamella
