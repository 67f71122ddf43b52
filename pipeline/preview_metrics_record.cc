#include "pipeline/preview_metrics_record.h"

#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// null where there is no number or the pictures are equal.
Json Number(const std::optional<double>& value) {
  if (!value || !std::isfinite(*value)) return Json();
  return std::round(*value * 1e4) / 1e4;
}

Json ToJson(const PreviewMetrics& metrics) {
  return {{"psnr_srgb_db", Number(metrics.psnr_db)},
          {"psnr_srgb_seen_db", Number(metrics.psnr_seen_db)},
          {"ssim", Number(metrics.ssim)},
          {"ssim_seen", Number(metrics.ssim_seen)}};
}

Json ToJson(const HaloFigures& halo) {
  return {{"relative_error", Number(halo.relative_error)},
          {"relative_error_behind", Number(halo.behind)},
          {"relative_error_before", Number(halo.before)},
          {"share_of_pixels", Number(halo.share_of_pixels)},
          {"share_of_squared_error", Number(halo.share_of_squared_error)}};
}

Json ToJson(const AliasingResult& aliasing) {
  return {{"step_mm", Number(aliasing.step_mm)}, {"db", Number(aliasing.db)}};
}

Json ToJson(const DisplayTotals& totals) {
  return {{"rays", std::round(totals.rays)},
          {"bits", totals.bits},
          {"light_efficiency", totals.light_efficiency}};
}

// The means' fields of metrics.json.
Json MeansJson(const PreviewResult& result) {
  const GridMeans means = MeansOf(result);
  Json json = {
      {"psnr_srgb_seen_db", Number(means.psnr_seen_db)},
      {"worst_psnr_srgb_seen_db", Number(means.worst_psnr_seen_db)},
      {"ssim_seen", Number(means.ssim_seen)},
      {"known", Number(means.known)},
      {"seen", Number(means.seen)},
      {"to_band_limited",
       {{"psnr_srgb_seen_db", Number(means.to_band_limited_db)},
        {"ssim_seen", Number(means.to_band_limited_ssim)}}},
      {"band_limited_to_target", {{"psnr_srgb_seen_db", Number(means.band_limited_to_target_db)}}}};
  if (means.halo) json["halo"] = ToJson(*means.halo);
  json["angular_aliasing"] = ToJson(result.aliasing);
  return json;
}

Json PositionOf(const Eye& eye) {
  const auto rounded = [](double mm) { return std::round(mm * 1e6) / 1e6; };
  return {rounded(eye.position.x()), rounded(eye.position.y()), rounded(eye.position.z())};
}

Json ToJson(const EyeResult& eye) {
  Json json = {{"eye", eye.name},
               {"position_mm", PositionOf(eye.eye)},
               {"simulated", "views/eye_" + eye.name + ".png"},
               {"target", "views/target_" + eye.name + ".png"},
               {"known", Number(MeanShare(eye.simulated))},
               {"seen", Number(MeanShare(eye.target.picture))}};
  json.update(ToJson(eye.metrics));
  json["to_band_limited"] = ToJson(eye.band_limit.simulated);
  const PreviewMetrics& target = eye.band_limit.target;
  json["band_limited_to_target"] = {{"psnr_srgb_db", Number(target.psnr_db)},
                                    {"psnr_srgb_seen_db", Number(target.psnr_seen_db)}};
  const std::optional<HaloFigures> halo = eye.halo ? FiguresOf(*eye.halo) : std::nullopt;
  if (halo) json["halo"] = ToJson(*halo);
  return json;
}

Json ToJson(const CapturedResult& captured) {
  return {{"view", captured.view},
          {"simulated", "views/at_" + captured.view + "_simulated.png"},
          {"direct", "views/at_" + captured.view + "_direct.png"},
          {"position_mm", PositionOf(captured.eye)},
          {"pixel_mm", captured.eye.pixel_mm},
          {"simulated_to_captured", ToJson(captured.simulated_to_captured)},
          {"direct_to_captured", ToJson(captured.direct_to_captured)},
          {"simulated_to_direct", ToJson(captured.simulated_to_direct)}};
}

}  // namespace

std::string MetricsJson(const PreviewResult& result, const PreviewOptions& options) {
  Json grid = Json::array(), further = Json::array(), captured = Json::array();
  Json focus = Json::array();
  for (const EyeResult& eye : result.grid) grid.push_back(ToJson(eye));
  for (const EyeResult& eye : result.further) further.push_back(ToJson(eye));
  for (const EyeResult& eye : result.focus) {
    focus.push_back(ToJson(eye));
    focus.back()["plane_mm"] = Number(eye.eye.plane_mm);
    focus.back()["pupil_mm"] = Number(eye.pupil->diameter_mm);
  }
  for (const CapturedResult& view : result.captured) captured.push_back(ToJson(view));
  const Eye& eye = result.grid[0].eye;
  const Json json = {{"format_version", 1},
                     {"border_px", options.border_px},
                     {"source", options.source},
                     {"width_px", eye.width},
                     {"height_px", eye.height},
                     {"pixel_mm", eye.pixel_mm},
                     {"left_mm", eye.left_mm},
                     {"top_mm", eye.top_mm},
                     {"totals", ToJson(result.totals)},
                     {"mean", MeansJson(result)},
                     {"eyes", grid},
                     {"further_eyes", further},
                     {"focus", focus},
                     {"captured_views", captured}};
  // Names of files need not be UTF-8.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace lamella
