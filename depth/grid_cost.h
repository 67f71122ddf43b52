// Matching cost on a regular camera grid.
//
// A label is a disparity d; a source view (dc, dr) steps away shows a reference pixel's point at
// (x - d dc, y - d dr): one constant sub-pixel shift per label and source, so the source is
// resampled by a 4-tap Catmull-Rom filter with constant weights.
//
//   sample = 0.3 min(mean over RGB of |dI|, 20) + 4 min(|dgx| + |dgy|, 10)       [8-bit codes]
//   with g = half the central differences of luma; samples outside of the source cost half of the
//   largest value, so that the side that sees the pixel wins
//   arm    = 3x3 box of the sum over the sources on one side of the reference
//   cost   = the smallest mean over any contiguous half of the arms: an occluder hides one side of
//   a
//            pixel, the other side is whole
#pragma once

#include <cstdint>
#include <vector>

#include "depth/cost_volume.h"
#include "lightfield/image.h"

namespace lamella {

// A view as the cost reads it: 16-bit planes with a border of repeated edge pixels.
class GridImage {
 public:
  static constexpr int kBorder = 4;   // px: filter taps and the gradient's neighbours
  static constexpr int kScale = 128;  // of an 8-bit code

  // `color`: planes R, G, B; else one plane of luma.
  GridImage(ImageSpan<const Rgb8> image, bool color);

  int width() const { return width_; }
  int height() const { return height_; }
  bool color() const { return num_planes_ == 3; }
  int num_planes() const { return num_planes_; }
  // Row y of a plane, at x = 0; y is clamped to the border's rows.
  const std::int16_t* Row(int plane, int y) const;

 private:
  int width_ = 0, height_ = 0, num_planes_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<std::int16_t> values_;
};

struct GridSource {
  const GridImage* image = nullptr;
  int columns = 0, rows = 0;  // steps from the reference
};
using GridArm = std::vector<GridSource>;  // up to kMaxArmSources sources on one side
constexpr int kMaxArmSources = 8;
constexpr int kMaxArms = 8;

struct DisparityLabels {
  double first = 0, step = 1;  // px per grid step
  int count = 0;
  double Disparity(double label) const { return first + step * label; }
};

// Costs are 6 times the mean sample, saturated. `arms` (4 or 8, some may be empty) go around the
// reference in order; all images have one size and the same planes. `memory`: that of an earlier
// volume.
CostVolume GridCost(const GridImage& reference, const std::vector<GridArm>& arms,
                    const DisparityLabels& labels, VolumeBytes memory = {});

}  // namespace lamella
