// Matching cost of a photograph by a sweep of planes (Collins 1996) of uniform inverse depth.
//
// A label is an inverse depth w. A reference pixel's ray (x, y, 1) meets the plane of depth 1/w in
// front of the reference at the point that a source shows at
//   p' ~ M (x, y, 1) + w b,   M = Ks R Kr^-1,  b = Ks t,   source_from_reference = (R, t)
// so the source is warped onto the reference once per label (bilinear, 1/64 px).
//
//   sample = Hamming distance of the 5x5 census of the warped source and of the reference, 0..24:
//            exposure may change from view to view; where the source does not see the point, 14,
//            slightly worse than chance
//   cost   = 3x3 box of the mean of the better half of the sources: an occluder hides a point from
//            some of them
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "depth/cost_volume.h"
#include "lightfield/image.h"

namespace lamella {

// Luma as the sweep reads it: each element holds four pixels, so that one gather fetches all that a
// bilinear sample needs. At most 32767 px wide and high.
class SweepImage {
 public:
  explicit SweepImage(Image<std::uint8_t> luma);
  int width() const { return luma_.width(); }
  int height() const { return luma_.height(); }
  const Image<std::uint8_t>& luma() const { return luma_; }
  // Bytes from the lowest: (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1); edges repeat.
  const std::uint32_t* quads() const { return quads_.data(); }

 private:
  Image<std::uint8_t> luma_;
  std::vector<std::uint32_t> quads_;
};

struct SweepSource {
  const SweepImage* image = nullptr;
  Eigen::Matrix3d m;  // pixels of the reference to the source's, both continuous
  Eigen::Vector3d b;
};
constexpr int kMaxSweepSources = 8;

// Inverse depths (1 / world unit), rising; they need not be evenly spaced.
struct InverseDepthLabels {
  std::vector<double> w;
  int count() const { return static_cast<int>(w.size()); }
  // Between labels: a share of the step to the next or from the last one.
  double InverseDepth(SubLabel label) const;
};

// Costs are 8 times the mean distance, saturated. 1 to kMaxSweepSources sources. `memory`: that of
// an earlier volume.
CostVolume SweepCost(const SweepImage& reference, const std::vector<SweepSource>& sources,
                     const InverseDepthLabels& labels, VolumeBytes memory = {});

}  // namespace lamella
