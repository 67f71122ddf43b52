// Semi-global matching (Hirschmueller 2008) over four paths: from the left, right, top and bottom.
//
//   L(p, d) = C(p, d) + min(L(q, d), L(q, d-1) + P1, L(q, d+1) + P1, min_k L(q, k) + P2)
//             - min_k L(q, k)                                     with q before p on the path
//   S(p, d) = sum of L over the paths; the label of p is the first minimum of S
//
// Four paths and no more: eight flatten slanted surfaces on clean data.
#pragma once

#include <cstdint>

#include "depth/cost_volume.h"
#include "lightfield/image.h"

namespace lamella {

struct SgmPenalties {
  static constexpr int kMaxPenalty = 255 - CostVolume::kMaxCost;

  int p1 = 6;  // for a step of one label
  // For a larger step: p2 / (1 + |dI| / p2_contrast), at least p1 + 2, where dI is the difference
  // of the guide along the path. 0: p2 everywhere. p1 < p2 <= kMaxPenalty.
  int p2 = 45;
  int p2_contrast = 0;
};

struct LabelMap {
  // Winner refined by a parabola through S at the winner and its neighbours; the first and the last
  // label have no fit.
  Image<SubLabel> label;
  // (S2 - S1) / (S1 + 4) of the winner S1 and the best label S2 more than two labels away, in
  // 1/255, saturated; 0 at the first and the last label.
  Image<std::uint8_t> uniqueness;
};

// `guide` has the volume's size. The result is exact (integers only) and independent of threads.
// `paths`: memory of the volume's size, to be used again.
LabelMap SemiGlobalMatch(const CostVolume& cost, ImageSpan<const std::uint8_t> guide,
                         const SgmPenalties& penalties, VolumeBytes& paths);
inline LabelMap SemiGlobalMatch(const CostVolume& cost, ImageSpan<const std::uint8_t> guide,
                                const SgmPenalties& penalties) {
  VolumeBytes paths;
  return SemiGlobalMatch(cost, guide, penalties, paths);
}

}  // namespace lamella
