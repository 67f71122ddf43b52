// The cost of depth/plane_sweep.h by plain loops over pixels, sources and labels. Positions are
// rounded to 1/64 px as there; all else follows from the formula.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "depth/plane_sweep.h"

namespace lamella::reference {

// Luma 1..255 of a source where it shows the reference's pixel (x, y) at inverse depth w; 0 where
// it does not. The row's coordinates advance from x0 in 32-bit floats.
inline int WarpedLuma(const SweepSource& source, double w, int x0, int x, int y) {
  const Image<std::uint8_t>& luma = source.image->luma();
  const Eigen::Vector3d start = source.m * Eigen::Vector3d(x0 + 0.5, y + 0.5, 1) + w * source.b;
  const auto at = [&](int k, double scale) {
    return static_cast<float>(scale * start[k]) +
           static_cast<float>(x - x0) * static_cast<float>(scale * source.m(k, 0));
  };
  const float z = at(2, 1);
  if (!(z > 1e-6F)) return 0;
  const float reciprocal = 1.0F / z;
  const float u = at(0, 64) * reciprocal - 32.0F, v = at(1, 64) * reciprocal - 32.0F;
  const auto width = static_cast<float>(luma.width()), height = static_cast<float>(luma.height());
  const bool inside = u >= -32 && u <= 64 * (width - 0.5F) && v >= -32 && v <= 64 * (height - 0.5F);
  if (!inside) return 0;
  const int u64 = static_cast<int>(std::clamp(u, 0.0F, 64 * (width - 1)) + 0.5F);
  const int v64 = static_cast<int>(std::clamp(v, 0.0F, 64 * (height - 1)) + 0.5F);
  const int left = u64 / 64, top = v64 / 64, fx = u64 % 64, fy = v64 % 64;
  const int right = std::min(left + 1, luma.width() - 1),
            bottom = std::min(top + 1, luma.height() - 1);
  const int sum = (64 - fx) * (64 - fy) * luma(left, top) + fx * (64 - fy) * luma(right, top) +
                  (64 - fx) * fy * luma(left, bottom) + fx * fy * luma(right, bottom);
  return std::max(1, (sum + 2048) / 4096);
}

// Distance of the censuses around (x, y), 0..24, or 14 where the source does not see it.
inline int CensusDistance(const SweepImage& reference, const SweepSource& source, double w, int x0,
                          int x, int y) {
  const auto mine = [&](int u, int v) {
    return reference.luma()(std::clamp(u, 0, reference.width() - 1),
                            std::clamp(v, 0, reference.height() - 1));
  };
  const int centre = WarpedLuma(source, w, x0, x, y);
  if (centre == 0) return 14;
  int distance = 0;
  for (int v = y - 2; v <= y + 2; ++v) {
    for (int u = x - 2; u <= x + 2; ++u) {
      distance += (mine(u, v) > mine(x, y)) != (WarpedLuma(source, w, x0, u, v) > centre);
    }
  }
  return distance;
}

// `x0` is where the kernel's tile begins to warp.
inline int SweepCost(const SweepImage& reference, const std::vector<SweepSource>& sources, double w,
                     int x0, int x, int y) {
  const std::size_t half = (sources.size() + 1) / 2;
  int box = 0;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      std::vector<int> distances;
      for (const SweepSource& source : sources) {
        distances.push_back(CensusDistance(reference, source, w, x0, u, v));
      }
      std::sort(distances.begin(), distances.end());
      for (std::size_t k = 0; k < half; ++k) box += distances[k];
    }
  }
  return std::min(191, static_cast<int>(8.0 * box / (9.0 * static_cast<double>(half))));
}

}  // namespace lamella::reference
