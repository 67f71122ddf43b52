#include "pipeline/make_layers.h"

#include <utility>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

void SaveLayers(const StageRun& run, const LayersRecord& record, LayerImages images) {
  for (std::size_t layer = 0; layer < images.slots.size(); ++layer) {
    ParallelForEach(
        0, static_cast<std::int64_t>(images.slots[layer].size()), [&](std::int64_t slot) {
          EmitterImage& image = images.slots[layer][static_cast<std::size_t>(slot)];
          SaveEmitterImage(run.folder(), static_cast<int>(layer), static_cast<int>(slot), image);
          image = {};
        });
  }
  SaveLayersRecord(run.folder(), record);
}

StageReport Report(const LayersRecord& record, const std::string& note) {
  const Placement& p = record.placement;
  StageReport report;
  report.summary = {
      {"display", record.display.name},
      {"reference view", p.reference_view},
      {"depth", fmt::format("{:.4g} to {:.4g} shown at {:+.1f} to {:+.1f} mm", p.near, p.far,
                            p.near_mm, p.far_mm)},
      {"viewing distance", fmt::format("{:g} mm", p.viewing_distance_mm)},
      {"picture", fmt::format("{:.1f} x {:.1f} mm, {:.4f} mm a pixel of the view",
                              p.picture_width_mm, p.picture_height_mm, p.mm_per_view_px)},
      {"rays seen", fmt::format("{:.1f} % of the display's, {:.1f} % of the picture's",
                                100 * record.seen_share, 100 * record.seen_share_in_picture)}};
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
  RequireBarriers(display);
  return display;
}

StageReport MakeLayers(std::unique_ptr<const RaySource> world, LayersRecord record,
                       const LayersOptions& options, const std::string& note, StageRun& run,
                       Progress& progress) {
  LayerImages images =
      Distribute(*Placed(*world, record.placement), record.display, options, progress);
  world.reset();
  record.seen_share = images.seen_share;
  record.seen_share_in_picture =
      SeenShare(images, record.display, record.placement.picture_width_mm,
                record.placement.picture_height_mm);
  SaveLayers(run, record, std::move(images));
  return Report(record, note);
}

}  // namespace lamella
