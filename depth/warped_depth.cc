#include "depth/warped_depth.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include <Eigen/LU>

#include "depth/bundle_map.h"
#include "depth/forward_warp.h"
#include "depth/source_view.h"

namespace lamella {
namespace {

constexpr double kLargestStretch = 1;       // px of the target between neighbours of one surface
constexpr float kGuessedConfidence = 0.1F;  // below what layers and points take as sure

Eigen::Matrix4d TargetFromLevel(const View& target, const View& given, const DepthLevel& level) {
  const Rigid target_from_given = target.camera_from_world * Inverse(given.camera_from_world);
  Eigen::Matrix4d level_from_given = ViewFromWorld(given.camera, {});
  level_from_given.row(0) *= level.per_color_x;
  level_from_given.row(1) *= level.per_color_y;
  return ViewFromWorld(target.camera, target_from_given) * level_from_given.inverse();
}

}  // namespace

WarpedDepth::WarpedDepth(const View& target)
    : target_(target), inverse_depth_(target.camera.width, target.camera.height, kNoSurface) {}

void WarpedDepth::Add(const View& given, const DepthMap& depth) {
  const double baseline =
      (Centre(given.camera_from_world) - Centre(target_.camera_from_world)).norm();
  const double px_per_inverse_depth =
      std::max(baseline * target_.camera.fx, std::numeric_limits<double>::min());
  const SurfaceRule rule{kLargestStretch / px_per_inverse_depth, 0};
  const DepthLevel level =
      std::move(DepthPyramid(depth, given.camera.width, given.camera.height, rule).front());
  const Eigen::Matrix4d map = TargetFromLevel(target_, given, level);
  DrawBlocks(level, map, LandingBlocks(level, map, inverse_depth_.width(), inverse_depth_.height()),
             inverse_depth_.span());
}

DepthMap WarpedDepth::Result() const {
  Image<float> filled = inverse_depth_.Clone();
  // Again, for corners with nothing in their row and column.
  for (int pass = 0; pass < 2; ++pass)
    FillFromFartherSide(kNoSurface, filled.height(), filled.span());
  DepthMap map{Image<float>(filled.width(), filled.height()),
               Image<float>(filled.width(), filled.height())};
  for (std::size_t i = 0; i < filled.size(); ++i) {
    const float w = filled.data()[i];
    if (w == kNoSurface) continue;
    map.depth.data()[i] = 1 / std::max(w, 0.0F);
    map.confidence.data()[i] = inverse_depth_.data()[i] == kNoSurface ? kGuessedConfidence : 1.0F;
  }
  return map;
}

std::vector<int> NearestViews(const std::vector<View>& views, int target, std::vector<int> given,
                              int count) {
  const auto distance = [&](int v) {
    return (Centre(views[static_cast<std::size_t>(v)].camera_from_world) -
            Centre(views[static_cast<std::size_t>(target)].camera_from_world))
        .norm();
  };
  std::stable_sort(given.begin(), given.end(),
                   [&](int a, int b) { return distance(a) < distance(b); });
  if (given.size() > static_cast<std::size_t>(count)) given.resize(static_cast<std::size_t>(count));
  return given;
}

}  // namespace lamella
