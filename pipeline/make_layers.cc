#include "pipeline/make_layers.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/calibrated_map.h"
#include "pipeline/calibration_record.h"
#include "pipeline/emitter_files.h"
#include "pipeline/peak_memory.h"
#include "pipeline/place_capture.h"

namespace lamella {
namespace {

// Gives the distribution what --memory leaves it; warns, before the long work, where it is too
// little.
LayersOptions WithMemoryLeft(const LayersOptions& options, const RaySource& world,
                             const LayersRecord& record, std::vector<std::string>& warnings,
                             Progress& progress) {
  const double loading = PeakMemory::OwnMib() / 1024;
  const MemoryLeft memory = MemoryLeftOf(options.memory_gib, BytesOfOpenFiles(record.display));
  LayersOptions left = options;
  left.memory_gib = memory.room;
  const Calibration* calibration = record.calibration ? &*record.calibration : nullptr;
  const double strip = std::ldexp(LeastBytes(world, record.display, options, calibration), -30);
  const double least = std::max(loading, LeastBound(memory, strip));
  if (options.memory_gib < least) {
    warnings.push_back(fmt::format(
        "--memory {:g} cannot be held: the views took {:.2f} GiB while they were read, "
        "they and the files take {:.2f} and the lowest strip {:.2f}; --memory {:.2f} is "
        "the least that works",
        options.memory_gib, loading, memory.held, strip, std::ceil(100 * least) / 100));
    progress.Warn(warnings.back());
  }
  return left;
}

StageReport Report(const LayersRecord& record, const std::string& note) {
  StageReport report;
  report.summary = {{"display", record.display.name},
                    {"panels", record.calibration ? "as calibrated" : "as designed"}};
  for (auto& line : SummaryOf(record.placement)) report.summary.push_back(std::move(line));
  report.summary.emplace_back(
      "rays seen", fmt::format("{:.1f} % of the display's, {:.1f} % of the picture's",
                               100 * record.seen_share, 100 * record.seen_share_in_picture));
  if (!note.empty()) report.warnings.push_back(note);
  return report;
}

}  // namespace

Display DisplayFor(const LayersOptions& options) {
  Display display = FindDisplay(options.display);
  if (options.border_mm) display.border_mm = *options.border_mm;
  if (options.border_offset_mm) display.border_offset_mm = *options.border_offset_mm;
  if (options.placement.viewing_distance_mm) {
    display.viewing_distance_mm = *options.placement.viewing_distance_mm;
  }
  Check(display, options.display);
  return display;
}

std::optional<Calibration> CalibrationFor(const LayersOptions& options, const Display& display) {
  CheckOptions(options, display, !options.calibration.empty());
  if (options.calibration.empty()) return std::nullopt;
  Calibration calibration = LoadCalibration(options.calibration);
  CheckCalibrates(calibration, display, options.calibration);
  return calibration;
}

StageReport MakeLayers(std::unique_ptr<const RaySource> world, LayersRecord record,
                       const LayersOptions& options, const std::string& note, StageRun& run,
                       Progress& progress) {
  if (!note.empty()) progress.Warn(note);
  const PictureSize picture{record.placement.picture_width_mm, record.placement.picture_height_mm};
  EmitterFiles files(run.folder(), record.display);
  std::vector<std::string> warnings;
  const auto has_plate = [](const Layer& layer) { return layer.plate.has_value(); };
  const std::vector<Layer>& layers = record.display.layers;
  if (!record.calibration && std::any_of(layers.begin(), layers.end(), has_plate)) {
    warnings.emplace_back(
        "rays are drawn as if no glass were before the layers: give --calibration");
    progress.Warn(warnings.back());
  }
  const std::unique_ptr<const RaySource> placed = Placed(*world, record.placement);
  const SeenShares seen = Distribute(
      *placed, record.display, WithMemoryLeft(options, *placed, record, warnings, progress),
      picture, [&](const EmitterRows& rows) { files.Write(rows); }, progress,
      record.calibration ? &*record.calibration : nullptr);
  world.reset();
  record.seen_share = seen.of_all;
  record.seen_share_in_picture = seen.of_picture;
  SaveLayersRecord(run.folder(), record);
  StageReport report = Report(record, note);
  report.warnings.insert(report.warnings.end(), warnings.begin(), warnings.end());
  return report;
}

}  // namespace lamella
