// Depth of a view that came without it, from views of the same capture that came with it: their
// surfaces warped forward. On (x, y, 1/Z) the warp is one projective map (bundle_map.h); of several
// surfaces in one pixel the nearest is seen.
#pragma once

#include <vector>

#include "lightfield/depth_map.h"
#include "lightfield/image.h"
#include "lightfield/view.h"

namespace lamella {

// Pinhole views throughout.
class WarpedDepth {
 public:
  explicit WarpedDepth(const View& target);

  // The surface that `given` saw. Neighbouring pixels are one surface unless the target sees them
  // pulled apart by more than a pixel, or they stand out as a step (SurfaceRule).
  void Add(const View& given, const DepthMap& depth);

  // Of the target's size. Pixels that no given view shows take the farther of their neighbours'
  // depths (a disocclusion belongs to the background) with confidence 0.1, all others have 1; where
  // nothing at all was seen the whole map is unknown.
  DepthMap Result() const;

 private:
  const View& target_;
  Image<float> inverse_depth_;
};

// Those of `given` (indices of views) whose centres are nearest to that of view `target`, nearest
// first, at most `count`.
std::vector<int> NearestViews(const std::vector<View>& views, int target, std::vector<int> given,
                              int count);

}  // namespace lamella
