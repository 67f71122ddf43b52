// The stage layers: the capture placed in the display's volume and distributed to its layers.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/parallel.h"
#include "pipeline/capture_source.h"
#include "pipeline/depth_record.h"
#include "pipeline/layers_record.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"

namespace lamella {
namespace {

// Of depth maps, so many pixels a view tell where near and far are.
constexpr int kSamplesPerView = 40000;
constexpr float kLeastConfidence = 0.25F;  // less sure depth does not stretch the range

// 1/Z in the reference view of a view's known points that lie within the reference picture.
std::vector<double> InverseDepthsSeen(const View& view, const DepthMap& map,
                                      const View& reference) {
  const int width = map.depth.width(), height = map.depth.height();
  const int step = std::max(
      1, static_cast<int>(std::sqrt(static_cast<double>(map.depth.size()) / kSamplesPerView)));
  const Rigid reference_from_view = reference.camera_from_world * Inverse(view.camera_from_world);
  std::vector<double> inverse_depths;
  for (int y = step / 2; y < height; y += step) {
    for (int x = step / 2; x < width; x += step) {
      const float depth = map.depth(x, y);
      if (!(depth > 0) || map.confidence(x, y) < kLeastConfidence) continue;
      const auto direction = Unproject(view.camera, {(x + 0.5) * view.camera.width / width,
                                                     (y + 0.5) * view.camera.height / height});
      if (!direction) continue;
      const bool infinite = std::isinf(depth);
      const Eigen::Vector3d point =
          infinite ? reference_from_view.rotation * *direction
                   : reference_from_view * (static_cast<double>(depth) * *direction);
      const auto pixel = Project(reference.camera, point);
      if (!pixel || pixel->x() < 0 || pixel->x() > reference.camera.width || pixel->y() < 0 ||
          pixel->y() > reference.camera.height) {
        continue;
      }
      inverse_depths.push_back(infinite ? 0 : 1 / point.z());
    }
  }
  return inverse_depths;
}

DepthRange DepthRangeOfCapture(const Workspace& workspace, const ViewSet& set,
                               const View& reference) {
  std::vector<std::vector<double>> of_view(set.views.size());
  ParallelForEach(0, static_cast<std::int64_t>(set.views.size()), [&](std::int64_t i) {
    const View& view = set.views[static_cast<std::size_t>(i)];
    const DepthMap map = LoadDepthMap(workspace.Stage("depth") / (view.name + ".exr"));
    of_view[static_cast<std::size_t>(i)] = InverseDepthsSeen(view, map, reference);
  });
  std::vector<double> all;
  for (const std::vector<double>& some : of_view) all.insert(all.end(), some.begin(), some.end());
  return DepthRangeOf(std::move(all));
}

// The display with what the options change of it.
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

StageReport RunLayers(const Workspace& workspace, const LayersOptions& options,
                      const RenderOptions& render, StageRun& run, Progress& progress) {
  LayersRecord record;
  record.display = DisplayFor(options);
  const ViewSet set = LoadViewSet(workspace);
  const View& reference = ReferenceView(set.views, options.placement.reference_view);
  const DepthRange range = ChooseDepthRange(options.placement, FindRegularGrid(set.views), [&] {
    return DepthRangeOfCapture(workspace, set, reference);
  });
  std::string note;
  record.placement =
      Place(reference, range.near, range.far, record.display, options.placement, &note);

  std::unique_ptr<RaySource> capture = LoadCaptureSource(workspace, render, progress);
  LayerImages images =
      Distribute(*Placed(*capture, record.placement), record.display, options, progress);
  capture.reset();

  record.seen_share = images.seen_share;
  record.seen_share_in_picture =
      SeenShare(images, record.display, record.placement.picture_width_mm,
                record.placement.picture_height_mm);
  SaveLayers(run, record, std::move(images));
  return Report(record, note);
}

}  // namespace lamella
