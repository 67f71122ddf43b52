#include "pipeline/preview_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/analysis_figure.h"
#include "pipeline/analysis_record.h"
#include "pipeline/depth_record.h"
#include "pipeline/emitter_rows.h"
#include "pipeline/frame_pictures.h"
#include "pipeline/report/picture.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kDepthViews = 12;   // on the page, spread over the capture
constexpr int kSmallWidth = 480;  // px, of photographs, depth maps and emitter images
constexpr std::size_t kEyeBytes = 12U << 20U;

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

// Of the figures that there are and that are finite; nothing without any.
class MeanOfFigures {
 public:
  void Add(const std::optional<double>& value) {
    if (!value || !std::isfinite(*value)) return;
    sum_ += *value;
    ++count_;
  }
  std::optional<double> Value() const {
    return count_ > 0 ? std::optional(sum_ / count_) : std::nullopt;
  }

 private:
  double sum_ = 0;
  int count_ = 0;
};

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

std::string Millimetres(double value) { return fmt::format("{:+.1f}", value + 0.0); }

// ---- Pictures ----

// The grid's pictures, simulated and target by turns, as data URIs of at most `width` px.
std::vector<std::string> EncodeEyes(const PreviewResult& result, int width, int quality) {
  std::vector<std::string> uris(2 * result.grid.size());
  ParallelForEach(0, static_cast<std::int64_t>(uris.size()), [&](std::int64_t i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const EyeResult& eye = result.grid[at / 2];
    const Image<Rgb8>& codes = at % 2 == 0 ? eye.simulated.codes : eye.target.picture.codes;
    uris[at] =
        codes.width() <= width
            ? DataUri(codes.span(), "jpeg", quality)
            : DataUri(PageCodes(DecodeSrgb8(codes.span()).span(), width).span(), "jpeg", quality);
  });
  return uris;
}

// Of the eye that focuses, as wide as the page's other eyes.
void AddFocus(const PreviewResult& result, PreviewPage& page) {
  page.focus.resize(result.focus.size());
  ParallelForEach(0, static_cast<std::int64_t>(page.focus.size()), [&](std::int64_t i) {
    const EyeResult& eye = result.focus[static_cast<std::size_t>(i)];
    const auto uri = [&](const PreviewPicture& picture) {
      const Image<Rgb> light = DecodeSrgb8(picture.codes.span());
      return DataUri(PageCodes(light.span(), page.width).span(), "jpeg", 82);
    };
    page.focus[static_cast<std::size_t>(i)] = {eye.eye.plane_mm, uri(eye.simulated),
                                               uri(eye.target.picture), eye.metrics.psnr_seen_db,
                                               eye.metrics.ssim_seen};
  });
  if (!result.focus.empty()) page.pupil_mm = result.focus[0].pupil->diameter_mm;
}

void AddEyes(const PreviewResult& result, PreviewPage& page) {
  struct Effort {
    int width, quality;
  };
  std::vector<std::string> uris;
  for (const auto [width, quality] :
       {Effort{640, 85}, {560, 80}, {448, 78}, {320, 75}, {200, 70}}) {
    uris = EncodeEyes(result, width, quality);
    std::size_t bytes = 0;
    for (const std::string& uri : uris) bytes += uri.size();
    page.width = std::min(width, result.grid[0].eye.width);
    if (bytes <= kEyeBytes) break;
  }
  const Eye& first = result.grid[0].eye;
  page.height = std::max(1, static_cast<int>(std::lround(static_cast<double>(first.height) *
                                                         page.width / first.width)));
  for (std::size_t i = 0; i < result.grid.size(); ++i) {
    const EyeResult& eye = result.grid[i];
    page.eyes.push_back({std::move(uris[2 * i]), std::move(uris[2 * i + 1]),
                         eye.metrics.psnr_seen_db, eye.metrics.ssim_seen, MeanShare(eye.simulated),
                         MeanShare(eye.target.picture)});
  }
}

int WidthOnPage(bool is_reference) { return is_reference ? 2 * kSmallWidth : kSmallWidth; }

void AddDepth(const Workspace& workspace, const ViewSet& set, const Placement& placement,
              const std::vector<Image<Rgb8>>& photographs, PreviewPage& page) {
  const std::vector<std::size_t> choice = ViewsOnPage(set, placement.reference_view);
  std::vector<DepthMap> maps(choice.size());
  std::vector<const DepthMap*> pointers;
  ParallelForEach(0, static_cast<std::int64_t>(choice.size()), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    maps[at] = LoadDepthMap(workspace.Stage("depth") / (set.views[choice[at]].name + ".exr"));
  });
  for (const DepthMap& map : maps) pointers.push_back(&map);
  const DepthScale scale = ScaleOf(pointers);
  page.depth_views.resize(choice.size());
  ParallelForEach(0, static_cast<std::int64_t>(choice.size()), [&](std::int64_t i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const View& view = set.views[choice[at]];
    const bool reference = view.name == placement.reference_view;
    page.depth_views[at] = {
        view.name, DataUri(photographs.at(at).span(), "jpeg", 82),
        DataUri(ColoredDepth(maps[at], scale, WidthOnPage(reference)).span(), "png"),
        KnownShare(maps[at]), reference};
  });
  constexpr int kTicks = 5;
  for (int i = 0; i < kTicks; ++i) {
    const double share = i / (kTicks - 1.0), inverse = scale.InverseAt(share);
    const double depth = inverse > 0 ? 1 / inverse : std::numeric_limits<double>::infinity();
    page.depth_ticks.emplace_back(
        share, fmt::format("{}\n{} mm", inverse > 0 ? fmt::format("{:.4g}", depth) : "\u221e",
                           Millimetres(placement.ZFromDepth(depth))));
  }
  page.depth_note =
      "Depth along the view's axis in world units, coloured by its inverse (blue far, red near); "
      "below, where that depth of the reference view lies in the display.";
}

PageLayer LayerOnPage(const Display& display, std::size_t index, const OpenEmitters& emitters) {
  const Layer& layer = display.layers[index];
  const RowOf mean = MeanRows(emitters, display, static_cast<int>(index));
  return {
      fmt::format("Layer {} at {} mm{}", index, Millimetres(layer.position_mm),
                  layer.mirror_x ? ", its panel seen in a mirror" : ""),
      DataUri(
          PageCodes(display.emitter_columns(), display.emitter_rows(), mean, kSmallWidth).span(),
          "jpeg", 82)};
}

// ---- Text ----

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

void AddFacts(const LayersRecord& record, const PreviewResult& result,
              const PreviewOptions& options, PreviewPage& page) {
  const Display& display = record.display;
  const Placement& p = record.placement;
  const Layer& layer = display.layers[0];
  const auto add = [&](const std::string& name, const std::string& value) {
    page.facts.emplace_back(name, value);
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
}

// The display's cut-off over depth beside the depths of the scene.
void AddCutoff(const Workspace& workspace, const Display& display, PreviewPage& page) {
  const Analysis analysis = Analyze(display, DepthsFor(display, SceneDepths(workspace)));
  const SceneAnalysis scene = AnalyzeWorkspace(workspace, display, analysis);
  page.cutoff = SvgDataUri(AnalysisFigure(display, analysis, scene));
  page.cutoff_text = fmt::format(
      "{:.0f} % of the reference view's known pixels lie at depths that a layer shows at the full "
      "resolution of its lattice.",
      100 * scene.figures.sharp_share);
  if (scene.figures.detail_kept) {
    page.cutoff_text += fmt::format(
        " Of the picture's detail {:.0f} % lies below the cut-off at its depth{}.",
        100 * *scene.figures.detail_kept,
        scene.figures.detail_kept_beam ? fmt::format(", {:.0f} % by the beams' real widths",
                                                     100 * *scene.figures.detail_kept_beam)
                                       : "");
  }
}

void AddLayers(const Display& display, const OpenEmitters& emitters, PreviewPage& page) {
  page.layers.resize(display.layers.size());
  ParallelForEach(0, static_cast<std::int64_t>(page.layers.size()), [&](std::int64_t i) {
    const auto l = static_cast<std::size_t>(i);
    page.layers[l] = LayerOnPage(display, l, emitters);
  });
}

// Each fills its own fields of the page.
void AddPictures(const Workspace& workspace, const LayersRecord& record, const ViewSet& set,
                 const OpenEmitters& emitters, const std::vector<Image<Rgb8>>& photographs,
                 const PreviewResult& result, const PreviewOptions& options, PreviewPage& page) {
  const std::function<void()> parts[] = {
      [&] {
        AddEyes(result, page);
        AddFocus(result, page);  // as wide as the eyes
      },
      [&] { AddDepth(workspace, set, record.placement, photographs, page); },
      [&] { AddLayers(record.display, emitters, page); },
      [&] {
        page.steps = options.source == "frames"
                         ? StepsOfFrames(workspace.Stage("frames"), record.display, emitters)
                         : StepsOfLayers(record.display, emitters);
      },
      [&] { AddCutoff(workspace, record.display, page); }};
  ParallelForEach(0, std::ssize(parts), [&](std::int64_t i) { parts[i](); });
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
  PageTable table{"Halos and shimmer of the same eyes", {"Figure", "Against the target"}, {}};
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
                   result.aliasing.step_mm),
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

void AddTables(const PreviewResult& result, PreviewPage& page) {
  const auto position = [](const Eye& eye) {
    return Millimetres(eye.position.x()) + ", " + Millimetres(eye.position.y());
  };
  page.tables.push_back(TableOfMeans(result));
  page.tables.push_back(TableOfArtefacts(result));
  if (!result.further.empty()) {
    page.tables.push_back(
        TableOfEyes("Further eyes, simulated against target", "Eye, mm", result.further, position));
  }
  if (!result.focus.empty()) {
    page.tables.push_back(TableOfEyes("The eye in the middle, focused; simulated against target",
                                      "Focused on, mm", result.focus,
                                      [](const Eye& eye) { return Millimetres(eye.plane_mm); }));
  }
  if (result.captured.empty()) return;
  PageTable table{"Captured views that stand at an eye position, PSNR in dB (sRGB)",
                  {"View", "Eye, mm", "Simulated against captured",
                   "Direct rendering against captured", "Simulated against direct rendering"},
                  {}};
  for (const CapturedResult& captured : result.captured) {
    table.rows.push_back({captured.view, position(captured.eye),
                          Decibels(captured.simulated_to_captured.psnr_seen_db),
                          Decibels(captured.direct_to_captured.psnr_seen_db),
                          Decibels(captured.simulated_to_direct.psnr_seen_db)});
  }
  page.tables.push_back(std::move(table));
}

}  // namespace

std::string BeyondEyeBox(const Display& display) {
  const bool bare = std::all_of(
      display.layers.begin(), display.layers.end(),
      [](const Layer& layer) { return std::holds_alternative<BarePanel>(layer.optics); });
  return bare ? "the layers' pictures off each other" : "light of neighbouring windows";
}

std::string Decibels(const std::optional<double>& value) {
  if (!value) return "no pixels";
  return std::isfinite(*value) ? fmt::format("{:.1f}", *value) : "equal";
}

GridMeans MeansOf(const PreviewResult& result) {
  GridMeans means;
  MeanOfFigures psnr, ssim, to_limited, to_limited_ssim, limited;
  HaloErrors halo;
  const double n = static_cast<double>(result.grid.size());
  for (const EyeResult& eye : result.grid) {
    const std::optional<double>& decibels = eye.metrics.psnr_seen_db;
    psnr.Add(decibels);
    ssim.Add(eye.metrics.ssim_seen);
    if (decibels && std::isfinite(*decibels)) {
      means.worst_psnr_seen_db = std::min(means.worst_psnr_seen_db.value_or(*decibels), *decibels);
    }
    to_limited.Add(eye.band_limit.simulated.psnr_seen_db);
    to_limited_ssim.Add(eye.band_limit.simulated.ssim_seen);
    limited.Add(eye.band_limit.target.psnr_seen_db);
    if (eye.halo) halo += *eye.halo;
    means.known += MeanShare(eye.simulated) / n;
    means.seen += MeanShare(eye.target.picture) / n;
  }
  means.halo = FiguresOf(halo);
  means.psnr_seen_db = psnr.Value();
  means.ssim_seen = ssim.Value();
  means.to_band_limited_db = to_limited.Value();
  means.to_band_limited_ssim = to_limited_ssim.Value();
  means.band_limited_to_target_db = limited.Value();
  return means;
}

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

// Up to kDepthViews, evenly spread, the reference view among them.
std::vector<std::size_t> ViewsOnPage(const ViewSet& set, const std::string& reference) {
  std::vector<std::size_t> choice;
  const std::size_t n = set.views.size(), count = std::min<std::size_t>(n, kDepthViews);
  for (std::size_t i = 0; i < count; ++i) {
    choice.push_back(count == 1 ? 0 : i * (n - 1) / (count - 1));
  }
  for (std::size_t v = 0; v < n; ++v) {
    if (set.views[v].name == reference) choice.push_back(v);
  }
  std::sort(choice.begin(), choice.end());
  choice.erase(std::unique(choice.begin(), choice.end()), choice.end());
  return choice;
}

Image<Rgb8> PhotographOnPage(ImageSpan<const Rgb> photograph, bool is_reference) {
  return PageCodes(photograph, WidthOnPage(is_reference));
}

PreviewPage MakePreviewPage(const Workspace& workspace, const LayersRecord& record,
                            const ViewSet& set, const OpenEmitters& emitters,
                            const std::vector<Image<Rgb8>>& photographs,
                            const PreviewResult& result, const PreviewOptions& options) {
  const Display& display = record.display;
  PreviewPage page;
  page.title = fmt::format("{} views on {}", set.views.size(), display.name);
  page.subtitle = fmt::format("Layers at {}, seen from {:.0f} mm", ListOfLayers(display),
                              record.placement.viewing_distance_mm);
  page.foot = fmt::format("Made by lamella {}. This file needs no network.", ProgramVersion());
  const std::size_t n = static_cast<std::size_t>(options.positions);
  for (std::size_t i = 0; i < n; ++i) {
    page.x_mm.push_back(result.grid[i].eye.position.x());
    page.y_mm.push_back(result.grid[i * n].eye.position.y());
  }
  page.distance_mm = record.placement.viewing_distance_mm;
  page.clean_box_mm = CleanEyeBox(display);
  page.beyond_box = BeyondEyeBox(display);
  AddPictures(workspace, record, set, emitters, photographs, result, options, page);
  AddFacts(record, result, options, page);
  page.metrics_note = fmt::format(
      "8-bit sRGB codes; a border of {} px is left out, and so are pixels that no camera saw. The "
      "target is the capture rendered along the same lines of sight without a display. The "
      "band-limited target is that blurred depth by depth, as wide as the beams are of the layers "
      "that show it: what they can carry. What is between it and the simulated picture is the "
      "display's own error.",
      options.border_px);
  AddTables(result, page);
  return page;
}

}  // namespace lamella
