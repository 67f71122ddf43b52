// Depth of a camera grid's view against the true disparity, by the rule of the HCI 4D light field
// benchmark.
#pragma once

#include <cstdint>
#include <filesystem>

#include "lightfield/image.h"

namespace lamella {

struct DepthComparison {
  std::int64_t pixels = 0;  // compared: finite truth, border left out
  std::int64_t unknown =
      0;  // of these, without an estimate; they count as bad, and not in mse_x100
  double bad_07 = 0, bad_03 = 0, bad_01 = 0;  // BadPix: per cent with |error| > 0.07, 0.03, 0.01 px
  double mse_x100 = 0;                        // 100 * mean squared error, px^2
};

constexpr int kBenchmarkBorder = 15;  // px

// Both in px per view step; NaN in `disparity` is unknown. One size (else InputError).
DepthComparison CompareDisparity(ImageSpan<const float> disparity, ImageSpan<const float> truth,
                                 int border = kBenchmarkBorder);

// `depth`: W/depth/NAME.exr of a finished workspace W, whose poses give the grid's two numbers.
// `truth`: a PFM of disparities. InputError where the workspace's views are no regular grid or the
// sizes differ.
DepthComparison CompareDepth(const std::filesystem::path& depth,
                             const std::filesystem::path& truth);

}  // namespace lamella
