// The colour-weighted median by sorting.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "depth/refine.h"

namespace lamella::reference {

inline SubLabel WeightedMedianAt(const Image<SubLabel>& labels, const Image<Rgb8>& guide,
                                 int radius, int x, int y) {
  if (labels(x, y) == kNoLabel) return kNoLabel;
  std::vector<std::pair<SubLabel, long>> votes;
  long total = 0;
  for (int v = y - radius; v <= y + radius; ++v) {
    for (int u = x - radius; u <= x + radius; ++u) {
      if (u < 0 || v < 0 || u >= labels.width() || v >= labels.height()) continue;
      if (labels(u, v) == kNoLabel) continue;
      const Rgb8 a = guide(x, y), b = guide(u, v);
      const int distance = std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
      const long weight = std::lround(255 * std::exp(-distance / 30.0));
      votes.emplace_back(labels(u, v), weight);
      total += weight;
    }
  }
  std::sort(votes.begin(), votes.end());
  long below = 0;
  for (const auto& [label, weight] : votes) {
    below += weight;
    if (2 * below >= total) return label;
  }
  return kNoLabel;
}

}  // namespace lamella::reference
