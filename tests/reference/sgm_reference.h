// Semi-global matching as the formula of depth/sgm.h says it, in plain integers without bounds.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "depth/sgm.h"

namespace lamella::reference {

// S by pixel and label.
inline std::vector<std::vector<int>> SumOfPaths(const CostVolume& cost,
                                                const Image<std::uint8_t>& guide,
                                                const SgmPenalties& penalties) {
  const int width = cost.width, height = cost.height, labels = cost.labels;
  std::vector<std::vector<int>> sums(static_cast<std::size_t>(width * height),
                                     std::vector<int>(static_cast<std::size_t>(labels), 0));
  const int steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (const auto& step : steps) {
    std::vector<std::vector<int>> paths(sums.size());
    for (int i = 0; i < width * height; ++i) {
      const int y = step[1] < 0 ? height - 1 - i / width : i / width;
      const int x = step[0] < 0 ? width - 1 - i % width : i % width;
      const int qx = x - step[0], qy = y - step[1];
      auto& path = paths[static_cast<std::size_t>(y * width + x)];
      for (int d = 0; d < labels; ++d) path.push_back(cost.At(x, y)[d]);
      if (qx < 0 || qy < 0 || qx >= width || qy >= height) continue;
      const auto& before = paths[static_cast<std::size_t>(qy * width + qx)];
      const int lowest = *std::min_element(before.begin(), before.end());
      int p2 = penalties.p2;
      if (penalties.p2_contrast > 0) {
        const int contrast = std::abs(guide(x, y) - guide(qx, qy));
        p2 = penalties.p2 * penalties.p2_contrast / (penalties.p2_contrast + contrast);
      }
      p2 = std::max(p2, penalties.p1 + 2);
      for (int d = 0; d < labels; ++d) {
        int best = std::min(before[static_cast<std::size_t>(d)], lowest + p2);
        if (d > 0) best = std::min(best, before[static_cast<std::size_t>(d - 1)] + penalties.p1);
        if (d + 1 < labels)
          best = std::min(best, before[static_cast<std::size_t>(d + 1)] + penalties.p1);
        path[static_cast<std::size_t>(d)] += best - lowest;
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t d = 0; d < sums[i].size(); ++d) sums[i][d] += paths[i][d];
    }
  }
  return sums;
}

}  // namespace lamella::reference
