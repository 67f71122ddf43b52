// Plane sweep for photographs: what matching costs at every pixel and inverse depth.
#pragma once

#include <cstdint>
#include <vector>

#include "depth/cost_volume.h"
#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/rigid.h"

namespace lamella {

// Labels are uniform in inverse depth, w = 1/Z: equal steps in the images (Gallup et al. 2008).
// w0 = 0 is infinity.
struct InverseDepthRange {
  double w0 = 0, w1 = 0;  // 1 / world units; w0 < w1
  int labels = 0;         // >= 2
  double Step() const { return (w1 - w0) / (labels - 1); }
  double At(double label) const { return w0 + label * Step(); }
};

struct SweepSource {
  ImageSpan<const std::uint8_t> grey;  // of the camera's size
  Camera camera;                       // pinhole
  Rigid source_from_reference;         // camera frames
};

// The cost of pixel p at inverse depth w, in 0..191:
//   census 5x5 of each source warped by the plane at w against the reference's (24 comparisons;
//   Zabih and Woodfill 1994: it does not mind exposure), 14 where the source does not see the
//   point; mean of the ceil(n/2) smallest over the n sources, since an occluder hides a point from
//   some; mean over 3x3 pixels.
// Integers after the warp's coordinates, whose float operations are exact IEEE ones: the same
// bytes on every machine and for every number of threads. 1 to 8 sources; sources of at least
// 2x2 pixels.
CostVolume SweepPlanes(ImageSpan<const std::uint8_t> reference, const Camera& camera,
                       const std::vector<SweepSource>& sources, const InverseDepthRange& range);

}  // namespace lamella
