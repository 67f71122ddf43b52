#include "pipeline/preview_emitters.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/calibrated_eyes.h"
#include "pipeline/emitter_files.h"
#include "pipeline/panel_images.h"
#include "pipeline/peak_memory.h"

namespace lamella {
namespace {

double Gib(double bytes) { return std::ldexp(bytes, -30); }

PanelImages OpenShown(const Workspace& workspace, const LayersRecord& record,
                      const PreviewOptions& options) {
  if (options.source == "frames") return OpenPanelImages(workspace, record);
  return {OpenEmitterFiles(workspace, record.display), false};
}

// All emitters, and the prototype's panels of a calibrated display.
double BytesOfWhole(const LayersRecord& record) {
  double bytes = BytesOfAll(record.display);
  if (!record.calibration) return bytes;
  for (std::size_t l = 0; l < record.display.layers.size(); ++l) {
    const double k = SlotsPerAxis(record.display.layers[l]);
    const bool modulated = record.calibration->layers[l].modulator.has_value();
    // Light and what is known of it.
    bytes += k * k * record.display.width_px * record.display.height_px *
             (2 * sizeof(Rgb) + (modulated ? sizeof(float) : 0));
  }
  return bytes;
}

// The frames that threads read for the page, emitter's and modulator's.
double BytesOfPageFrames(const Display& display) {
  return 2.0 * NumThreads() * sizeof(Rgb8) * display.width_px * display.height_px;
}

// A viewer's picture while it is simulated, through a pupil twice, and the light that is kept of
// the middle eye and of the one beside it.
double BytesOfSimulation(const std::vector<Viewer>& viewers) {
  double pixels = 0;
  for (const Viewer& viewer : viewers) {
    pixels = std::max(pixels, static_cast<double>(viewer.eye.width) * viewer.eye.height);
  }
  return pixels * (2 * (sizeof(Rgb) + sizeof(float)) + 2 * sizeof(float));
}

// Warns where `left` has no room for so much of `what`.
void CheckRoom(const PreviewOptions& options, const MemoryLeft& left, double loading_gib,
               double room_gib, const char* what, std::vector<std::string>& warnings,
               Progress& progress) {
  const double least = std::max(loading_gib, LeastBound(left, room_gib));
  if (options.memory_gib >= least) return;
  warnings.push_back(fmt::format(
      "--memory {:g} cannot be held: the views took {:.2f} GiB while targets were rendered, the "
      "eyes' pictures and open files take {:.2f} and {} {:.2f}; --memory {:.2f} is the least that "
      "works",
      options.memory_gib, loading_gib, left.held, what, room_gib, std::ceil(100 * least) / 100));
  progress.Warn(warnings.back());
}

}  // namespace

PreviewEmitters PrepareEmitters(const Workspace& workspace, const LayersRecord& record,
                                const PreviewOptions& options, const std::vector<Viewer>& viewers,
                                double page_bytes, std::vector<std::string>& warnings,
                                Progress& progress) {
  const double loading = PeakMemory::OwnMib() / 1024;
  PanelImages shown = OpenShown(workspace, record, options);
  double pictures = 0;
  for (const Viewer& viewer : viewers) {
    pictures +=
        static_cast<double>(viewer.eye.width) * viewer.eye.height * (sizeof(Rgb8) + sizeof(float));
  }
  const Display& display = record.display;
  const MemoryLeft left = MemoryLeftOf(
      options.memory_gib, BytesOfOpenFiles(display) + pictures + BytesOfSimulation(viewers));
  PreviewEmitters emitters{std::move(shown.open), shown.grey, nullptr, {}};
  const double whole = Gib(BytesOfWhole(record)),
               page = Gib(BytesOfPageFrames(display) + page_bytes);
  double needed = whole + page;
  const char* what = record.calibration
                         ? "a calibrated display's emitters, all at once, and the page"
                         : "the emitters and the page";
  if (record.calibration || whole + page <= left.room) {
    emitters.whole = std::make_unique<const LayerImages>(ReadWhole(emitters.open, display));
    emitters.open = OpenImages(*emitters.whole);
  } else {
    emitters.strips = PlanStrips(display, viewers, std::ldexp(left.room, 30));
    needed = std::max(Gib(BytesOf(emitters.strips, display)), page);
    what = "the page or the lowest strip of emitters";
  }
  CheckRoom(options, left, loading, needed, what, warnings, progress);
  return emitters;
}

void SimulateViewers(const PreviewEmitters& emitters, const LayersRecord& record,
                     const std::vector<Viewer>& viewers, const TakePictureRows& take,
                     Progress& progress) {
  const Display& display = record.display;
  if (!emitters.whole) {
    std::size_t parts = 0;
    for (const EmitterStripPlan& strip : emitters.strips) parts += strip.parts.size();
    progress.Start("preview: simulated eyes", static_cast<std::int64_t>(parts), "parts of eyes");
    SimulateStrips(emitters.strips, emitters.open, display, viewers,
                   [&](std::size_t viewer, int first_row, const EyePicture& rows) {
                     take(viewer, first_row, rows);
                     progress.Advance();
                   });
    return;
  }
  std::optional<CalibratedEyes> calibrated;
  if (record.calibration) calibrated.emplace(record, *emitters.whole);
  progress.Start("preview: simulated eyes", std::ssize(viewers), "eyes");
  for (std::size_t i = 0; i < viewers.size(); ++i) {
    const auto& [eye, pupil] = viewers[i];
    take(i, 0,
         calibrated ? calibrated->See(eye, pupil)
                    : SimulateEye(*emitters.whole, display, eye, pupil));
    progress.Advance();
  }
}

}  // namespace lamella
