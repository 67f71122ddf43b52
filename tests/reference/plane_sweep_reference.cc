#include "tests/reference/plane_sweep_reference.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace lamella {
namespace {

struct Sample {
  int value = 0;
  bool seen = false;
};

Eigen::Matrix3d Intrinsics(const Camera& camera) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return k;
}

// The source at the point that the reference sees at pixel (x, y) and inverse depth w:
//   (u, v, z) ~ K_s (R K_r^-1 (0.5, y + 0.5, 1) + w t) + column * K_s R K_r^-1 (1, 0, 0)    in
//   floats,
// 6-bit weights, rounded to a code; outside of the picture the nearest inside.
Sample Warp(const SweepSource& source, const Camera& camera, int x, int y, double w) {
  const Eigen::Matrix3d k = Intrinsics(source.camera);
  const Eigen::Matrix3d turn =
      k * source.source_from_reference.rotation.toRotationMatrix() * Intrinsics(camera).inverse();
  const Eigen::Vector3d shift = k * source.source_from_reference.translation;
  const Eigen::Vector3f start = (turn * Eigen::Vector3d(0.5, y + 0.5, 1) + w * shift).cast<float>();
  const Eigen::Vector3f step = turn.col(0).cast<float>();
  const Eigen::Vector3f n = static_cast<float>(x) * step + start;
  Sample sample;
  const bool front = n.z() > 0;
  const float z = front ? n.z() : 1.0F;
  const float px = (n.x() / z - 0.5F) * 64.0F, py = (n.y() / z - 0.5F) * 64.0F;
  const auto max_x = static_cast<float>((source.grey.width - 1) * 64 - 1);
  const auto max_y = static_cast<float>((source.grey.height - 1) * 64 - 1);
  sample.seen = front && px >= 0 && px <= max_x && py >= 0 && py <= max_y;
  const int fu = static_cast<int>(std::clamp(px, 0.0F, max_x));
  const int fv = static_cast<int>(std::clamp(py, 0.0F, max_y));
  const int ix = fu / 64, iy = fv / 64, wx = fu % 64, wy = fv % 64;
  const auto at = [&](int dx, int dy) { return static_cast<int>(source.grey(ix + dx, iy + dy)); };
  const int top = at(0, 0) * (64 - wx) + at(1, 0) * wx;
  const int bottom = at(0, 1) * (64 - wx) + at(1, 1) * wx;
  sample.value = (top * (64 - wy) + bottom * wy + 2048) / 4096;
  return sample;
}

int Census(ImageSpan<const std::uint8_t> reference, const Camera& camera, const SweepSource& source,
           int x, int y, double w) {
  const Sample centre = Warp(source, camera, x, y, w);
  if (!centre.seen) return 14;
  int distance = 0;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      const int rx = std::clamp(x + dx, 0, reference.width - 1);
      const int ry = std::clamp(y + dy, 0, reference.height - 1);
      const bool brighter = reference(rx, ry) > reference(x, y);
      distance += brighter != (Warp(source, camera, x + dx, y + dy, w).value > centre.value);
    }
  }
  return distance;
}

}  // namespace

CostVolume SweepPlanesReference(ImageSpan<const std::uint8_t> reference, const Camera& camera,
                                const std::vector<SweepSource>& sources,
                                const InverseDepthRange& range) {
  const int width = reference.width, height = reference.height;
  CostVolume volume(width, height, range.labels);
  std::fill_n(volume.costs.get(), volume.Bytes(), static_cast<std::uint8_t>(CostVolume::kMaxCost));
  const std::size_t keep = (sources.size() + 1) / 2;
  for (int label = 0; label < range.labels; ++label) {
    Image<int> best(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        std::vector<int> costs;
        for (const SweepSource& source : sources) {
          costs.push_back(Census(reference, camera, source, x, y, range.At(label)));
        }
        std::sort(costs.begin(), costs.end());
        for (std::size_t k = 0; k < keep; ++k) best(x, y) += costs[k];
      }
    }
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        int sum = 0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            sum += best(std::clamp(x + dx, 0, width - 1), std::clamp(y + dy, 0, height - 1));
          }
        }
        const int factor =
            8 * 65536 / (9 * static_cast<int>(keep));  // of the mean, 16-bit fixed point
        volume.At(x, y)[label] = static_cast<std::uint8_t>(std::min(191, sum * factor / 65536));
      }
    }
  }
  return volume;
}

}  // namespace lamella
