#include "pipeline/preview_tables.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <variant>

#include <fmt/format.h>

namespace lamella {
namespace {

std::string OpticsInWords(const Layer& layer) {
  if (const Barrier* barrier = std::get_if<Barrier>(&layer.optics)) {
    return fmt::format("a barrier of {0}x{0} px every {1} px, {2} time slots", barrier->aperture_px,
                       barrier->period_px, barrier->slots * barrier->slots);
  }
  if (const LensletArray* lenses = std::get_if<LensletArray>(&layer.optics)) {
    return fmt::format("{} lenslets every {:g} px, {}x{} rays",
                       lenses->lattice == LensletArray::Lattice::kSquare ? "square" : "hexagonal",
                       lenses->pitch_px, lenses->rays, lenses->rays);
  }
  if (const BarePanel* bare = std::get_if<BarePanel>(&layer.optics)) {
    return fmt::format("bare panels for eyes in {0:g} x {0:g} mm", bare->eye_box_mm);
  }
  const Lenticular& lenses = std::get<Lenticular>(layer.optics);
  return fmt::format("lenticular lenses of {:g} sub-pixels, {} views", lenses.subpixels_per_lens,
                     lenses.views);
}

std::string Similarity(const std::optional<double>& ssim) {
  return ssim ? fmt::format("{:.3f}", *ssim) : "-";
}

// The means of the eyes that the page moves between.
PageTable TableOfMeans(const PreviewResult& result) {
  const GridMeans means = MeansOf(result);
  PageTable table{"Means over the eyes above", {"Compared", "PSNR, dB (sRGB)", "SSIM"}, {}};
  table.rows.push_back(
      {"simulated, target", Decibels(means.psnr_seen_db), Similarity(means.ssim_seen)});
  table.rows.push_back({"simulated, band-limited target", Decibels(means.to_band_limited_db),
                        Similarity(means.to_band_limited_ssim)});
  table.rows.push_back(
      {"band-limited target, target", Decibels(means.band_limited_to_target_db), "-"});
  return table;
}

// What layers and directions do to the picture, of the same eyes.
PageTable TableOfArtefacts(const PreviewResult& result) {
  const auto percent = [](const std::optional<double>& share) {
    return share ? fmt::format("{:+.1f} %", 100 * *share) : std::string("-");
  };
  PageTable table{
      "Halos and shimmer of the same eyes", {"Figure", "Against the band-limited target"}, {}};
  if (const std::optional<HaloFigures> halo = MeansOf(result).halo) {
    table.rows.push_back(
        {"light behind the edges of what occludes another layer's content", percent(halo->behind)});
    table.rows.push_back({"light on the near side of these edges", percent(halo->before)});
    table.rows.push_back({"pixels that such halos reach; their share of the squared error",
                          fmt::format("{:.1f} %; {:.1f} %", 100 * halo->share_of_pixels,
                                      100 * halo->share_of_squared_error)});
  }
  table.rows.push_back(
      {fmt::format("angular aliasing, middle eye against one {:.1f} mm beside it, dB",
                   std::abs(result.aliasing.step_mm)),
       Decibels(result.aliasing.db)});
  return table;
}

// A row for each eye, under the column `place`.
PageTable TableOfEyes(const std::string& title, const std::string& place,
                      const std::vector<EyeResult>& eyes,
                      const std::function<std::string(const Eye&)>& place_of) {
  PageTable table{title,
                  {place, "PSNR, dB (sRGB)", "of all pixels", "SSIM", "PSNR to band-limited",
                   "SSIM to band-limited", "of band-limited"},
                  {}};
  for (const EyeResult& eye : eyes) {
    const auto& [simulated, target] = eye.band_limit;
    table.rows.push_back({place_of(eye.eye), Decibels(eye.metrics.psnr_seen_db),
                          Decibels(eye.metrics.psnr_db), Similarity(eye.metrics.ssim_seen),
                          Decibels(simulated.psnr_seen_db), Similarity(simulated.ssim_seen),
                          Decibels(target.psnr_seen_db)});
  }
  return table;
}

// An eye's place in its plane.
std::string PositionInWords(const Eye& eye) {
  return Millimetres(eye.position.x()) + ", " + Millimetres(eye.position.y());
}

PageTable TableOfCaptured(const std::vector<CapturedResult>& views) {
  PageTable table{"Captured views that stand at an eye position, PSNR in dB (sRGB)",
                  {"View", "Eye, mm", "Simulated against captured",
                   "Direct rendering against captured", "Simulated against direct rendering"},
                  {}};
  for (const CapturedResult& captured : views) {
    table.rows.push_back({captured.view, PositionInWords(captured.eye),
                          Decibels(captured.simulated_to_captured.psnr_seen_db),
                          Decibels(captured.direct_to_captured.psnr_seen_db),
                          Decibels(captured.simulated_to_direct.psnr_seen_db)});
  }
  return table;
}

}  // namespace

std::string Millimetres(double value) { return fmt::format("{:+.1f}", value + 0.0); }

std::string Decibels(const std::optional<double>& value) {
  if (!value) return "no pixels";
  return std::isfinite(*value) ? fmt::format("{:.1f}", *value) : "equal";
}

std::string BeyondEyeBox(const Display& display) {
  const bool bare = std::all_of(
      display.layers.begin(), display.layers.end(),
      [](const Layer& layer) { return std::holds_alternative<BarePanel>(layer.optics); });
  return bare ? "the layers' pictures off each other" : "light of neighbouring windows";
}

std::string ListOfLayers(const Display& display) {
  constexpr std::size_t kMost = 6;
  const std::size_t n = display.layers.size();
  if (n > kMost) {
    return fmt::format("{} to {} mm", Millimetres(display.layers.front().position_mm),
                       Millimetres(display.layers.back().position_mm));
  }
  std::string text;
  for (const Layer& layer : display.layers) {
    text += (text.empty() ? "" : ", ") + Millimetres(layer.position_mm);
  }
  return text + " mm";
}

std::vector<std::pair<std::string, std::string>> PreviewFacts(const LayersRecord& record,
                                                              const PreviewResult& result,
                                                              const PreviewOptions& options) {
  std::vector<std::pair<std::string, std::string>> facts;
  const Display& display = record.display;
  const Placement& p = record.placement;
  const Layer& layer = display.layers[0];
  const auto add = [&](const std::string& name, const std::string& value) {
    facts.emplace_back(name, value);
  };
  add("Display", display.name);
  add("Panels",
      fmt::format("{} x {} px of {:.4g} mm, {} layers at {}", display.width_px, display.height_px,
                  display.pitch_mm, display.layers.size(), ListOfLayers(display)));
  add("Optics", OpticsInWords(layer));
  add("Brightness", fmt::format("{:.2f} % of an emitter's light reaches the eye",
                                100 * Brightness(display, layer)));
  add("Display rays",
      fmt::format("{:.4g} million in all layers and slots", result.totals.rays / 1e6));
  add("Panels' bits", fmt::format("{:.4g} million a picture", result.totals.bits / 1e6));
  add("Reference view", p.reference_view);
  add("Depth placed", fmt::format("{:.4g} to {:.4g} world units", p.near, p.far));
  add("in the display",
      fmt::format("{} to {} mm (front positive)", Millimetres(p.near_mm), Millimetres(p.far_mm)));
  add("Depth budget", fmt::format("\u00b1{:.1f} mm at full resolution", DepthBudgetMm(display)));
  add("One view pixel", fmt::format("{:.4f} mm on the plane z = 0", p.mm_per_view_px));
  add("Viewing distance", fmt::format("{:.0f} mm", p.viewing_distance_mm));
  add("Display rays seen",
      fmt::format("{:.1f} % by a captured view; {:.1f} % of those through "
                  "the picture",
                  100 * record.seen_share, 100 * record.seen_share_in_picture));
  const Eye& eye = result.grid[0].eye;
  add("Eye pictures", fmt::format("{} x {} px of {:.4f} mm", eye.width, eye.height, eye.pixel_mm));
  add("Simulated from", options.source == "frames"
                            ? "the panels' 8-bit images, decoded back"
                            : "the layers' emitter images before they become frames");
  return facts;
}

std::vector<PageTable> PreviewTables(const PreviewResult& result) {
  std::vector<PageTable> tables = {TableOfMeans(result), TableOfArtefacts(result)};
  if (!result.further.empty()) {
    tables.push_back(TableOfEyes("Further eyes, simulated against target", "Eye, mm",
                                 result.further, PositionInWords));
  }
  if (!result.focus.empty()) {
    tables.push_back(TableOfEyes("The eye in the middle, focused; simulated against target",
                                 "Focused on, mm", result.focus,
                                 [](const Eye& eye) { return Millimetres(eye.plane_mm); }));
  }
  if (!result.captured.empty()) tables.push_back(TableOfCaptured(result.captured));
  return tables;
}

}  // namespace lamella
