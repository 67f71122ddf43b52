#include "pipeline/place_capture.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "lightfield/parallel.h"
#include "pipeline/depth_record.h"

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

DepthRange DepthRangeOfCapture(const Workspace& workspace, const std::vector<View>& views,
                               const View& reference) {
  std::vector<std::vector<double>> of_view(views.size());
  ParallelForEach(0, static_cast<std::int64_t>(views.size()), [&](std::int64_t i) {
    const View& view = views[static_cast<std::size_t>(i)];
    const DepthMap map = LoadDepthMap(workspace.Stage("depth") / (view.name + ".exr"));
    of_view[static_cast<std::size_t>(i)] = InverseDepthsSeen(view, map, reference);
  });
  std::vector<double> all;
  for (const std::vector<double>& some : of_view) all.insert(all.end(), some.begin(), some.end());
  return DepthRangeOf(std::move(all));
}

}  // namespace

Placement PlaceCapture(const Workspace& workspace, const std::vector<View>& views,
                       const Display& display, const PlacementOptions& options, std::string* note) {
  const View& reference = ReferenceView(views, options.reference_view);
  const DepthRange range = ChooseDepthRange(options, FindRegularGrid(views), [&] {
    return DepthRangeOfCapture(workspace, views, reference);
  });
  return Place(reference, range.near, range.far, display, options, note);
}

std::vector<std::pair<std::string, std::string>> SummaryOf(const Placement& p) {
  return {{"reference view", p.reference_view},
          {"depth", fmt::format("{:.4g} to {:.4g} shown at {:+.1f} to {:+.1f} mm", p.near, p.far,
                                p.near_mm, p.far_mm)},
          {"viewing distance", fmt::format("{:g} mm", p.viewing_distance_mm)},
          {"picture", fmt::format("{:.1f} x {:.1f} mm, {:.4f} mm a pixel of the view",
                                  p.picture_width_mm, p.picture_height_mm, p.mm_per_view_px)}};
}

}  // namespace lamella
