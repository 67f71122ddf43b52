#include "pipeline/analysis_table.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "lightfield/bandwidth.h"

namespace lamella {
namespace {

constexpr std::size_t kMostLayers = 32;      // more are left out in the middle
constexpr int kDepths = 12;                  // steps of the table over depth
constexpr std::size_t kHalf = 1, kFull = 2;  // of Analysis::frequencies

// Of a box: "+-55.1", "any", "none".
std::string Half(double mm) {
  if (std::isinf(mm)) return "any";
  return mm > 0 ? fmt::format("+-{:.1f}", mm) : "none";
}

std::string BoxText(const EyeRectangle& box) {
  return box.x_mm == box.y_mm ? Half(box.x_mm) : Half(box.x_mm) + " x " + Half(box.y_mm);
}

void AddLayers(const Analysis& analysis, std::string& text) {
  auto out = std::back_inserter(text);
  fmt::format_to(out,
                 "{:>5} {:>9} {:>8} {:>8} {:>8} {:>8} {:>9} {:>6} {:>5} {:>8} {:>7} {:>10}  {}\n",
                 "layer", "z mm", "d0 mm", "dx mm", "du mm", "z_max mm", "sharpest", "FOV", "views",
                 "step mm", "light", "rays", "eyes mm");
  const std::size_t count = analysis.layers.size();
  for (std::size_t l = 0; l < count; ++l) {
    if (count > kMostLayers && l == kMostLayers / 2) {
      fmt::format_to(out, "{:>5}\n", "...");
      l = count - kMostLayers / 2;
    }
    const LayerFigures& f = analysis.layers[l];
    fmt::format_to(
        out,
        "{:>5} {:>9.5g} {:>8.4g} {:>8.4f} {:>8.4f} {:>8.4g} {:>9.4g} {:>6.2f} {:>5} {:>8.2f} "
        "{:>6.2f}% {:>10.0f}  {}\n",
        l, f.position_mm, f.d0_mm, f.lattice_pitch_mm, f.direction_step_mm, f.sharp_range_mm,
        f.sharpest_mm, f.field_of_view_deg, f.directions_per_axis, f.view_spacing_mm,
        100 * f.light_efficiency, f.rays, BoxText(f.clean_eye_box));
  }
}

void AddWhole(const Analysis& analysis, std::string& text) {
  auto out = std::back_inserter(text);
  const int layers = static_cast<int>(analysis.layers.size());
  fmt::format_to(out, "rays             {:.0f}", analysis.totals.rays);
  if (analysis.rays_to_one_layer) {
    fmt::format_to(out, ", {:.4g} times those of one layer with the same range",
                   *analysis.rays_to_one_layer);
  }
  text += "\n";
  if (layers > 1) {
    fmt::format_to(out,
                   "                 {} layers that share a range evenly: {:.4g} times (full "
                   "parallax), {:g} times (horizontal only)\n",
                   layers, RayRatio(layers, 2), RayRatio(layers, 1));
  }
  fmt::format_to(out, "panels' bits     {:.0f} a picture\n", analysis.totals.bits);
  fmt::format_to(out, "full resolution ");
  constexpr std::size_t kMostIntervals = 8;
  for (std::size_t i = 0; i < std::min(analysis.sharp.size(), kMostIntervals); ++i) {
    fmt::format_to(out, "{} {:.5g} to {:.5g}", i == 0 ? "" : ",", analysis.sharp[i].from_mm,
                   analysis.sharp[i].to_mm);
  }
  fmt::format_to(out, "{} mm\n", analysis.sharp.size() > kMostIntervals ? ", ..." : "");
  const double guard = analysis.layers.front().guard_share;
  if (guard > 0) fmt::format_to(out, "guard pixels     {:.1f} %\n", 100 * guard);
  fmt::format_to(out, "clean eye box    {}{}\n", BoxText(analysis.clean_eye_box),
                 analysis.clean_eye_box.x_mm > 0 ? " mm" : "");
}

void AddFormula(double value, std::string& text) {
  fmt::format_to(std::back_inserter(text), " {:>6.3f}", value);
}

// Four columns of a frequency: alone, both, the same with the paper's beams, and those before one
// far eye.
void AddMtf(const Analysis& analysis, std::size_t frequency, std::size_t depth, std::string& text) {
  AddFormula(analysis.mtf.single[frequency][depth], text);
  AddFormula(analysis.mtf.both[frequency][depth], text);
  AddFormula(analysis.paper_mtf.single[frequency][depth], text);
  AddFormula(analysis.paper_mtf.both[frequency][depth], text);
  AddFormula(analysis.paper_mtf.fixed_eye[frequency][depth], text);
}

void AddDepths(const Analysis& analysis, std::string& text) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{:>9} {:>8} {:>8} | {:^34} | {:^34}\n", "", "cut-off", "its beam",
                 fmt::format("MTF at {:.4g} c/mm", analysis.frequencies[kHalf]),
                 fmt::format("MTF at {:.4g} c/mm", analysis.frequencies[kFull]));
  fmt::format_to(out, "{:>9} {:>8} {:>8} |", "z mm", "c/mm", "c/mm");
  for (int i = 0; i < 2; ++i) {
    fmt::format_to(out, " {:>6} {:>6} {:>6} {:>6} {:>6}{}", "alone", "both", "l.one", "l.both",
                   "l.eye", i == 0 ? " |" : "\n");
  }
  const double from = analysis.depths_mm.front(), to = analysis.depths_mm.back();
  for (int i = 0; i <= kDepths; ++i) {
    const double z = from + (to - from) * i / kDepths;
    const auto after = std::lower_bound(analysis.depths_mm.begin(), analysis.depths_mm.end(),
                                        z - 1e-9 * (to - from));
    const auto d = std::min(static_cast<std::size_t>(after - analysis.depths_mm.begin()),
                            analysis.depths_mm.size() - 1);
    fmt::format_to(out, "{:>9.5g} {:>8.4f} {:>8.4f} |", analysis.depths_mm[d], analysis.combined[d],
                   analysis.combined_beam[d]);
    AddMtf(analysis, kHalf, d, text);
    text += " |";
    AddMtf(analysis, kFull, d, text);
    text += "\n";
  }
  text +=
      "alone: the prefilter or the display; both: mean over views; l.: with lens beams as wide as "
      "the lattice;\nl.eye: both, before one far eye\n";
}

void AddScene(const SceneAnalysis& scene, std::string& text) {
  auto out = std::back_inserter(text);
  const SceneFigures& f = scene.figures;
  fmt::format_to(out, "scene            view {}, placed for {} at {:g} mm\n", scene.reference_view,
                 scene.placed_for, scene.viewing_distance_mm);
  fmt::format_to(out,
                 "depth            {:.4g} to {:.4g} mm (1 % to 99 % of pixels), known {:.1f} %\n",
                 f.far_mm, f.near_mm, 100 * f.known_share);
  fmt::format_to(out, "full resolution  {:.1f} % of the pixels lie where a layer has it\n",
                 100 * f.sharp_share);
  if (f.detail_kept && f.detail_kept_beam) {
    fmt::format_to(out,
                   "detail kept      {:.1f} % by Eq. 1, {:.1f} % by the real beams (energy of "
                   "periods of 2 to 16 px)\n",
                   100 * *f.detail_kept, 100 * *f.detail_kept_beam);
  }
  constexpr std::size_t kRows = 16, kWidth = 50;
  const std::size_t per_row = f.share.size() / kRows;
  std::vector<double> rows(kRows, 0);
  for (std::size_t i = 0; i < kRows * per_row; ++i) rows[i / per_row] += f.share[i];
  const double most = std::max(1e-9, *std::max_element(rows.begin(), rows.end()));
  for (std::size_t i = 0; i < kRows; ++i) {
    fmt::format_to(
        out, "{:>9.4g} to {:>7.4g} mm {:>6.2f} %  {}\n", f.edges_mm[i * per_row],
        f.edges_mm[(i + 1) * per_row], 100 * rows[i],
        std::string(static_cast<std::size_t>(std::lround(kWidth * rows[i] / most)), '#'));
  }
  if (f.share_behind > 0) fmt::format_to(out, "behind that {:.2f} %\n", 100 * f.share_behind);
  if (f.share_before > 0) fmt::format_to(out, "before that {:.2f} %\n", 100 * f.share_before);
}

}  // namespace

std::string AnalysisTable(const Display& display, const Analysis& analysis,
                          const std::optional<SceneAnalysis>& scene) {
  std::string text = fmt::format(
      "{}: {} layer{} of {}, {} x {} px, seen from {:g} mm\n", display.name, display.layers.size(),
      display.layers.size() == 1 ? "" : "s", NameOf(display.layers.front().optics),
      display.width_px, display.height_px, display.viewing_distance_mm);
  AddLayers(analysis, text);
  AddWhole(analysis, text);
  AddDepths(analysis, text);
  if (scene) AddScene(*scene, text);
  return text;
}

}  // namespace lamella
