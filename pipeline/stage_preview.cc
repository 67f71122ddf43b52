// The stage preview: simulated eyes, how far they are from the capture, and the page.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "distribute/analyze.h"
#include "distribute/angular_aliasing.h"
#include "distribute/band_limit.h"
#include "distribute/halo.h"
#include "distribute/place.h"
#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/calibrated_eyes.h"
#include "pipeline/capture_source.h"
#include "pipeline/depth_record.h"
#include "pipeline/layers_record.h"
#include "pipeline/overview.h"
#include "pipeline/peak_memory.h"
#include "pipeline/poses_record.h"
#include "pipeline/preview_emitters.h"
#include "pipeline/preview_eyes.h"
#include "pipeline/preview_measure.h"
#include "pipeline/preview_metrics_record.h"
#include "pipeline/preview_report.h"
#include "pipeline/preview_result.h"
#include "pipeline/preview_tables.h"
#include "pipeline/report/preview_page.h"
#include "pipeline/stages.h"
#include "pipeline/varifocal_frames.h"

namespace lamella {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kOverviewQuality = 92;  // of JPEG

// A captured view's eye with what is rendered there directly, before the layers are loaded.
struct DirectView {
  CapturedEye at;
  PreviewPicture captured, direct;
};

void AddEyes(const std::vector<Eigen::Vector2d>& positions, const Eye& central, const auto& name_of,
             std::vector<EyeResult>& eyes) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    EyeResult result;
    result.name = name_of(static_cast<int>(i));
    result.eye = central;
    result.eye.position.head<2>() = positions[i];
    eyes.push_back(std::move(result));
  }
}

void AddFocus(const Display& display, const Eye& central, const PreviewOptions& options,
              std::vector<EyeResult>& eyes) {
  for (const double plane : FocusPlanes(display, options.focus_planes)) {
    EyeResult result;
    result.name = fmt::format("focus_{:02}", eyes.size());
    result.eye = FocusedOn(central, plane);
    result.pupil = Pupil{options.pupil_mm};
    eyes.push_back(std::move(result));
  }
}

PreviewResult EyesOf(const Display& display, const Eye& central, const PreviewOptions& options) {
  PreviewResult result;
  AddEyes(
      EyeGrid(options), central,
      [&](int i) {
        return fmt::format("{:02}_{:02}", i / options.positions, i % options.positions);
      },
      result.grid);
  AddEyes(
      ParseEyes(options.eyes), central, [](int i) { return fmt::format("further_{:02}", i); },
      result.further);
  AddFocus(display, central, options, result.focus);
  return result;
}

// The captured views that stand at the eyes.
std::vector<DirectView> DirectViews(const ViewSet& set, const LayersRecord& record,
                                    const PreviewResult& result) {
  std::vector<Eigen::Vector2d> positions;
  for (const std::vector<EyeResult>* eyes : {&result.grid, &result.further}) {
    for (const EyeResult& eye : *eyes) positions.emplace_back(eye.eye.position.head<2>());
  }
  std::vector<DirectView> direct;
  for (CapturedEye& eye : CapturedEyes(set.views, record.placement, record.display, positions,
                                       result.grid[0].eye.pixel_mm)) {
    direct.push_back({eye, {}, {}});
  }
  return direct;
}

// As calibrated, where it is.
Display DisplayOf(const LayersRecord& record) {
  return record.calibration ? AsCalibrated(record.display, *record.calibration) : record.display;
}

// All eyes but those that stand where a captured view does.
std::vector<EyeResult*> AllEyes(PreviewResult& result) {
  std::vector<EyeResult*> all;
  for (std::vector<EyeResult>* eyes : {&result.grid, &result.further, &result.focus}) {
    for (EyeResult& eye : *eyes) all.push_back(&eye);
  }
  return all;
}

// Index of the grid's middle eye.
std::size_t GridMiddle(int positions) {
  const std::size_t n = static_cast<std::size_t>(positions), row = n / 2;
  return row * n + row;
}

// The grid's middle eye a step to the side, towards x = 0 where it has no eye there, for angular
// aliasing.
EyeResult BesideMiddle(const EyeResult& middle, double step_mm) {
  EyeResult beside;
  beside.eye = middle.eye;
  beside.eye.position.x() += middle.eye.position.x() > 0 ? -step_mm : step_mm;
  return beside;
}

// Pictures and metrics of all eyes. Targets come first, so that the capture and the emitter images
// are never in memory together. The middle eye and the one beside it keep theirs as light.
void RenderTargets(const RaySource& placed, double mm_per_view_px, TargetParts parts,
                   const EyeResult& middle, EyeResult& beside_middle, PreviewResult& result,
                   std::vector<DirectView>& direct, Progress& progress) {
  std::vector<EyeResult*> eyes = AllEyes(result);
  eyes.push_back(&beside_middle);
  progress.Start("preview: targets", static_cast<std::int64_t>(eyes.size() + direct.size()),
                 "eyes");
  for (EyeResult* eye : eyes) {
    parts.keeps_light = eye == &middle || eye == &beside_middle;
    eye->target = RenderTarget(placed, eye->eye, eye->pupil, mm_per_view_px, parts);
    progress.Advance();
  }
  for (DirectView& view : direct) {
    view.direct = RenderTarget(placed, view.at.eye, {}, mm_per_view_px, {}).picture;
    progress.Advance();
  }
}

// A display without colours is asked for none.
void LoseColors(PreviewResult& result, std::vector<DirectView>& direct) {
  for (EyeResult* eye : AllEyes(result)) {
    LoseColor(eye->target.picture.codes);
    LoseColor(eye->target.band_limited);
  }
  for (DirectView& view : direct) {
    LoseColor(view.captured.codes);
    LoseColor(view.direct.codes);
  }
}

// What the page and the comparisons need of a view's photograph. From many threads, each with
// another view.
void TakePhotograph(std::size_t view, ImageSpan<const Rgb> photograph, bool is_reference,
                    const std::vector<std::size_t>& on_page, std::vector<Image<Rgb8>>& photographs,
                    std::vector<DirectView>& direct) {
  for (std::size_t i = 0; i < on_page.size(); ++i) {
    if (on_page[i] == view) photographs[i] = PhotographOnPage(photograph, is_reference);
  }
  for (DirectView& eye : direct) {
    if (static_cast<std::size_t>(eye.at.view) == view) {
      eye.captured = CapturedPicture(photograph, eye.at);
    }
  }
}

// The pictures that the display shows: all eyes, the one beside the middle, captured views' eyes.
std::vector<Viewer> ViewersOf(const std::vector<EyeResult*>& eyes,
                              const std::vector<DirectView>& direct) {
  std::vector<Viewer> viewers;
  for (const EyeResult* eye : eyes) viewers.push_back({eye->eye, eye->pupil});
  for (const DirectView& view : direct) viewers.push_back({view.at.eye, {}});
  return viewers;
}

// Of the capture: depth maps, at most as large as their views, and the overview's photograph and
// map beside them.
double BytesOfPage(const ViewSet& set, const std::vector<std::size_t>& on_page) {
  double bytes = 0, largest = 0;
  for (const std::size_t view : on_page) {
    const Camera& camera = set.views[view].camera;
    const double pixels = static_cast<double>(camera.width) * camera.height;
    bytes += 2 * sizeof(float) * pixels;
    largest = std::max(largest, pixels);
  }
  return bytes + (sizeof(Rgb) + 2 * sizeof(float)) * largest;
}

std::vector<PreviewPicture> Simulate(const PreviewEmitters& emitters, const LayersRecord& record,
                                     const std::vector<Viewer>& viewers,
                                     const std::vector<EyeResult*>& eyes, Progress& progress) {
  std::vector<PreviewPicture> pictures;
  for (const auto& [eye, pupil] : viewers) {
    pictures.push_back({Image<Rgb8>(eye.width, eye.height), Image<float>(eye.width, eye.height)});
  }
  const TakePictureRows take = [&](std::size_t viewer, int first_row, const EyePicture& rows) {
    KeepRows(rows, first_row, pictures[viewer]);
    if (viewer < eyes.size() && eyes[viewer]->target.light) {
      AddSeen(rows, first_row, *eyes[viewer]->target.light);
    }
  };
  SimulateViewers(emitters, record, viewers, take, progress);
  return pictures;
}

// Takes the light of both eyes' targets.
AliasingResult MeasureAliasing(EyeResult& middle, EyeResult& beside, int border_px) {
  const SeenAgainstTarget a = std::move(middle.target.light).value();
  const SeenAgainstTarget b = std::move(beside.target.light).value();
  middle.target.light.reset();
  return {b.eye.position.x() - a.eye.position.x(), AngularAliasing(a, b, border_px)};
}

void MeasureEye(PreviewPicture simulated, int border_px, EyeResult& eye) {
  eye.simulated = std::move(simulated);
  eye.metrics = Compare(eye.simulated, eye.target.picture, border_px);
  eye.band_limit = CompareToBandLimited(eye.simulated, eye.target, border_px);
  eye.halo = MeasureHalo(eye.simulated, eye.target, border_px);
  eye.target.band_limited = {};
  eye.target.rims = {};
}

// `simulated`: of all eyes, the one beside the middle and the captured views' eyes.
void Measure(std::vector<PreviewPicture> simulated, const PreviewOptions& options,
             PreviewResult& result, std::vector<DirectView> direct, const ViewSet& set,
             Progress& progress) {
  progress.Start("preview: metrics", std::ssize(simulated) - 1, "eyes");
  auto picture = simulated.begin();
  for (EyeResult* eye : AllEyes(result)) {
    MeasureEye(std::move(*picture++), options.border_px, *eye);
    progress.Advance();
  }
  ++picture;
  for (DirectView& view : direct) {
    CapturedResult captured{set.views[static_cast<std::size_t>(view.at.view)].name,
                            view.at.eye,
                            std::move(*picture++),
                            std::move(view.direct),
                            {},
                            {},
                            {}};
    captured.simulated_to_captured = Compare(captured.simulated, view.captured, options.border_px);
    captured.direct_to_captured = Compare(captured.direct, view.captured, options.border_px);
    captured.simulated_to_direct = Compare(captured.simulated, captured.direct, options.border_px);
    result.captured.push_back(std::move(captured));
    progress.Advance();
  }
}

// Of one-bit planes, where the eyes see such.
std::optional<int> StrokesOf(const Workspace& workspace, const Display& display, bool one_bit) {
  if (!one_bit) return std::nullopt;
  const auto strokes = LoadStrokeFrames(workspace.Stage("frames"), display);
  return static_cast<int>(strokes.value().files.size());
}

void WriteViews(const std::filesystem::path& folder, PreviewResult& result) {
  CreateFolder(folder);
  struct File {
    std::string name;
    const PreviewPicture* picture;
    bool with_alpha;  // the share that the capture saw
  };
  std::vector<File> files;
  for (const EyeResult* eye : AllEyes(result)) {
    files.push_back({"eye_" + eye->name, &eye->simulated, false});
    files.push_back({"target_" + eye->name, &eye->target.picture, true});
  }
  for (const CapturedResult& view : result.captured) {
    files.push_back({"at_" + view.view + "_simulated", &view.simulated, false});
    files.push_back({"at_" + view.view + "_direct", &view.direct, true});
  }
  ParallelForEach(0, static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    const File& file = files[static_cast<std::size_t>(i)];
    const std::filesystem::path path = folder / (file.name + ".png");
    if (file.with_alpha) {
      WriteCodes8(path, file.picture->codes.span(), file.picture->share.span());
    } else {
      WriteCodes8(path, file.picture->codes.span(), kOverviewQuality, PngCoding::kPhotograph);
    }
  });
}

void WriteOverview(const Workspace& workspace, const std::filesystem::path& path, const View& view,
                   const LayersRecord& record, const OpenEmitters& emitters,
                   const PreviewResult& result, int positions) {
  const EyeResult& middle = result.grid[GridMiddle(positions)];
  const Image<Rgb8> overview =
      Overview(workspace.photographs().Linear(view.image).span(),
               LoadDepthMap(workspace.Stage("depth") / (view.name + ".exr")), emitters,
               record.display, middle.eye, middle.simulated.codes.span());
  WriteCodes8(path, overview.span(), kOverviewQuality);
}

std::vector<std::string> WarningsOf(const LayersRecord& record, const PreviewResult& result) {
  std::vector<std::string> warnings;
  const double box = CleanEyeBox(DisplayOf(record));
  const auto outside = std::count_if(result.grid.begin(), result.grid.end(), [&](const auto& eye) {
    return eye.eye.position.template head<2>().cwiseAbs().maxCoeff() > box;
  });
  if (outside > 0) {
    warnings.push_back(fmt::format(
        "{} of {} eyes stand outside the display's clean eye box of +-{:.0f} mm and see {}",
        outside, result.grid.size(), box, BeyondEyeBox(record.display)));
  }
  const double seen = MeansOf(result).seen;
  if (seen < 0.9) {
    warnings.push_back(fmt::format(
        "for {:.0f} % of the eyes' pictures the capture has no depth: the display is black there",
        100 * (1 - seen)));
  }
  return warnings;
}

// What the simulated panels lack; nothing where they are ideal. A calibration says itself how black
// its panels are.
std::string PanelsInWords(const Display& display, bool calibrated) {
  std::vector<std::string> words;
  if (!calibrated && std::isfinite(display.contrast)) {
    words.push_back(fmt::format("contrast {:g}:1", display.contrast));
  }
  std::vector<double> modulators;
  for (const Layer& layer : display.layers) {
    const auto* barrier = std::get_if<Barrier>(&layer.optics);
    if (barrier != nullptr && std::isfinite(barrier->contrast)) {
      modulators.push_back(barrier->contrast);
    }
  }
  if (!calibrated && !modulators.empty()) {
    words.push_back(fmt::format("modulators {:g}:1", fmt::join(modulators, ":1, ")));
  }
  if (display.slot_crosstalk > 0) {
    words.push_back(fmt::format("slot crosstalk {:g} %", 100 * display.slot_crosstalk));
  }
  return fmt::format("{}", fmt::join(words, "; "));
}

StageReport ReportOf(const LayersRecord& record, const PreviewResult& result,
                     const PreviewOptions& options) {
  const GridMeans means = MeansOf(result);
  StageReport report;
  report.summary = {
      {"eyes", fmt::format("{0} x {0} within +-{1:g} mm", options.positions, options.eye_box_mm)},
      {"mean PSNR of seen pixels against direct rendering (sRGB)",
       means.psnr_seen_db ? fmt::format("{:.2f} dB, worst {:.2f} dB", *means.psnr_seen_db,
                                        *means.worst_psnr_seen_db)
                          : "no figure: no pixel was seen, or all are equal"},
      {"mean SSIM of seen pixels",
       means.ssim_seen ? fmt::format("{:.4f}", *means.ssim_seen) : "no pixel was seen"},
      {"seen by the capture", fmt::format("{:.1f} %", 100 * means.seen)}};
  if (means.to_band_limited_db) {
    report.summary.emplace_back(
        "against what the layers' beams can carry",
        fmt::format("{:.2f} dB; that against direct rendering {} dB", *means.to_band_limited_db,
                    Decibels(means.band_limited_to_target_db)));
  }
  if (means.halo && means.halo->behind) {
    report.summary.emplace_back(
        "halos beside what stands before another layer's",
        fmt::format("{:+.1f} % of the light there, {:.0f} % of the squared error on {:.0f} % of "
                    "the pixels",
                    100 * *means.halo->behind, 100 * means.halo->share_of_squared_error,
                    100 * means.halo->share_of_pixels));
  }
  if (result.aliasing.db && std::isfinite(*result.aliasing.db)) {
    report.summary.emplace_back("angular aliasing", Decibels(result.aliasing.db) + " dB");
  }
  if (const std::string panels = PanelsInWords(record.display, record.calibration.has_value());
      !panels.empty()) {
    report.summary.emplace_back("panels", panels);
  }
  for (const CapturedResult& view : result.captured) {
    report.summary.emplace_back("against captured view " + view.view,
                                fmt::format("simulated {} dB, direct {} dB",
                                            Decibels(view.simulated_to_captured.psnr_seen_db),
                                            Decibels(view.direct_to_captured.psnr_seen_db)));
  }
  report.warnings = WarningsOf(record, result);
  return report;
}

// The times and warnings of the stages before, and of this one so far.
void AddStages(const Workspace& workspace, const StageReport& own, Clock::time_point start,
               PreviewPage& page) {
  for (const char* stage : {"capture", "poses", "depth", "layers", "frames"}) {
    const std::optional<StageRecord> record = LoadStageRecord(workspace, stage);
    if (!record) continue;
    page.stages.push_back({stage, record->seconds, record->peak_memory_mib});
    for (const std::string& warning : record->report.warnings) {
      page.warnings.push_back(fmt::format("{}: {}", stage, warning));
    }
    if (!record->report.missed_gate.empty()) {
      page.warnings.push_back(fmt::format("{}: {}", stage, record->report.missed_gate));
    }
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  page.stages.push_back({"preview (until this page)", seconds, PeakMemory::OwnMib()});
  for (const std::string& warning : own.warnings) page.warnings.push_back("preview: " + warning);
}

}  // namespace

OptionTable Describe(PreviewOptions& options) {
  return {"preview",
          {{"positions", "eye positions per axis", &options.positions, 1, 31},
           {"eye_box_mm", "the positions span +- this at the viewing distance, mm",
            &options.eye_box_mm, 0, 1e4},
           {"eyes", "further eyes to simulate and compare, \"X,Y;X,Y\" in mm", &options.eyes},
           {"width_px", "the eyes' pictures are at most so wide", &options.width_px, 16, 16384},
           {"eye_pixel_mm",
            "size of the eyes' pixels on z = 0, mm (default: the panel's pitch, or "
            "what width_px asks for)",
            &options.eye_pixel_mm, 1e-3, 1e3},
           {"border_px", "the metrics leave out a border of so many pixels", &options.border_px, 0,
            4096},
           {"focus_planes",
            "from the backmost to the frontmost layer, on which the eye in the middle focuses; "
            "0: none",
            &options.focus_planes, 0, 64},
           {"pupil_mm", "diameter of that eye's pupil, mm", &options.pupil_mm, 0, 50},
           {"source",
            "simulate from the panels' images or from the emitter images they were made of",
            &options.source,
            {},
            {},
            {"frames", "layers"}},
           MemoryField(options.memory_gib)}};
}

void ApplyQuality(Quality quality, PreviewOptions& options) {
  options.width_px = quality == Quality::kDraft ? 640 : quality == Quality::kBalanced ? 960 : 1920;
  options.positions = quality == Quality::kBest ? 7 : 5;
  options.focus_planes = quality == Quality::kBest ? 5 : 0;
}

StageReport RunPreview(const Workspace& workspace, const PreviewOptions& options,
                       const RenderOptions& render, StageRun& run, Progress& progress) {
  const Clock::time_point start = Clock::now();
  const LayersRecord record = LoadLayersRecord(workspace);
  const ViewSet set = LoadViewSet(workspace);
  const View& reference = ReferenceView(set.views, record.placement.reference_view);
  const Eye central = CentralEye(record.display, record.placement, reference, options);
  PreviewResult result = EyesOf(record.display, central, options);
  EyeResult& middle = result.grid[GridMiddle(options.positions)];
  EyeResult beside_middle = BesideMiddle(middle, AliasingStepMm(DisplayOf(record)));
  std::vector<DirectView> direct = DirectViews(set, record, result);
  const std::vector<std::size_t> on_page = ViewsOnPage(set, record.placement.reference_view);
  const auto reference_index = static_cast<std::size_t>(&reference - set.views.data());
  std::vector<Image<Rgb8>> photographs(on_page.size());
  {
    const std::unique_ptr<RaySource> source = LoadCaptureSource(
        workspace, render, progress, [&](std::size_t view, const DepthView& loaded) {
          TakePhotograph(view, loaded.color.span(), view == reference_index, on_page, photographs,
                         direct);
        });
    const std::unique_ptr<RaySource> placed = Placed(*source, record.placement);
    const BandLimit limit = BandLimitOf(DisplayOf(record));
    const std::optional<ShadowBlur> shadows = ShadowBlurOf(DisplayOf(record));
    RenderTargets(*placed, record.placement.mm_per_view_px, {&limit, shadows ? &*shadows : nullptr},
                  middle, beside_middle, result, direct, progress);
  }
  std::vector<EyeResult*> eyes = AllEyes(result);
  eyes.push_back(&beside_middle);
  const std::vector<Viewer> viewers = ViewersOf(eyes, direct);
  std::vector<std::string> warnings;
  const PreviewEmitters emitters = PrepareEmitters(workspace, record, options, viewers,
                                                   BytesOfPage(set, on_page), warnings, progress);
  if (emitters.grey) LoseColors(result, direct);
  result.totals = TotalsOf(record.display, StrokesOf(workspace, record.display, emitters.grey));
  std::vector<PreviewPicture> simulated = Simulate(emitters, record, viewers, eyes, progress);
  result.aliasing = MeasureAliasing(middle, beside_middle, options.border_px);
  Measure(std::move(simulated), options, result, std::move(direct), set, progress);
  WriteTextAtomically(run.folder() / "metrics.json", MetricsJson(result, options));
  StageReport report = ReportOf(record, result, options);
  report.warnings.insert(report.warnings.end(), warnings.begin(), warnings.end());
  PreviewPage page;
  const std::function<void()> parts[] = {
      [&] { WriteViews(run.folder() / "views", result); },
      [&] {
        WriteOverview(workspace, run.folder() / "overview.jpg", reference, record, emitters.open,
                      result, options.positions);
      },
      [&] {
        page = MakePreviewPage(workspace, record, set, emitters.open, photographs, result, options);
      }};
  progress.Start("preview: files", std::ssize(parts) + 1, "parts");
  ParallelForEach(0, std::ssize(parts), [&](std::int64_t i) {
    parts[i]();
    progress.Advance();
  });
  AddStages(workspace, report, start, page);
  WriteTextAtomically(run.folder() / "index.html", ToHtml(page));
  progress.Advance();
  return report;
}

}  // namespace lamella
