#include "pipeline/preview_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "distribute/analyze.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/analysis_figure.h"
#include "pipeline/analysis_record.h"
#include "pipeline/depth_record.h"
#include "pipeline/emitter_rows.h"
#include "pipeline/frame_pictures.h"
#include "pipeline/preview_tables.h"
#include "pipeline/report/picture.h"

namespace lamella {
namespace {

constexpr int kDepthViews = 12;   // on the page, spread over the capture
constexpr int kSmallWidth = 480;  // px, of photographs, depth maps and emitter images
constexpr std::size_t kEyeBytes = 12U << 20U;

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

}  // namespace

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
  page.facts = PreviewFacts(record, result, options);
  page.metrics_note = fmt::format(
      "8-bit sRGB codes; a border of {} px is left out, and so are pixels that no camera saw. The "
      "target is the capture rendered along the same lines of sight without a display. The "
      "band-limited target is that blurred depth by depth, as wide as the beams are of the layers "
      "that show it: what they can carry, but for the lean of slanted lenses. What is between it "
      "and the simulated picture is the display's own error.",
      options.border_px);
  page.tables = PreviewTables(result);
  return page;
}

}  // namespace lamella
