// Depth against truth: a camera grid's view against true disparity by the rule of the HCI 4D light
// field benchmark, or any view against true depth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

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

// Errors are relative, |Z - truth| / truth, in per cent; both are in the truth's world.
struct WorldDepthComparison {
  int maps = 0;
  std::vector<std::string> only_estimate, only_truth;  // names of files without a partner
  std::int64_t pixels = 0;                             // of the estimates, where the truth is known
  std::int64_t known = 0;                              // of these, with an estimate
  double median = 0, p90 = 0;                          // of the known ones' errors
  double within_1 = 0;         // per cent of the known ones whose error is at most 1 %
  double within_1_of_all = 0;  // the same of all: what is unknown counts against it
};

// A pixel of a smaller estimate is compared with the truth's pixel at its centre. At infinity only
// infinity is right. InputError where a pair's shapes differ by more than a rounded pixel.
struct DepthPair {
  Image<float> estimate, truth;
};
WorldDepthComparison CompareWorldDepth(std::span<const DepthPair> pairs);

// Two EXR files, or two folders of them: their files are matched by name, and InputError says so
// where no name meets.
WorldDepthComparison CompareWorldDepth(const std::filesystem::path& depth,
                                       const std::filesystem::path& truth);

}  // namespace lamella
