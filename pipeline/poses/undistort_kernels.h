// The inner loops of undistortion: where a row's pixels are in the original, and their colours
// there. No fused operations, so that every target gives the bytes of the plain formulas.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

// The pixels of a row in the original: continuous coordinates, not a number where it has no such
// place.
struct SourceRow {
  static constexpr int kMostStep = 16;         // px between knots
  static constexpr std::size_t kPadding = 32;  // kernels write so far beyond the last pixel

  explicit SourceRow(int width_px)
      : width(width_px),
        x(static_cast<std::size_t>(width_px) + kPadding),
        y(x.size()),
        first(x.size()),
        colors(x.size()) {
    for (auto& weight : across) weight.resize(x.size());
    for (auto& weight : down) weight.resize(x.size());
  }
  int width;
  std::vector<double> x, y;
  // Index of the upper left one of the 16 samples; -1 where they do not all lie in the original.
  std::vector<std::int32_t> first;
  std::array<std::vector<float>, 4> across, down;  // their weights
  std::vector<Rgb> colors;
};

// The `step` (at most kMostStep) pixels from `begin` on by the cubic through the places of the
// pixels begin - step, begin, begin + step and begin + 2 step.
void InterpolateSources(const std::array<Eigen::Vector2d, 4>& knots, int step, int begin,
                        SourceRow& row);

// Catmull-Rom where all 16 samples lie in the image; finds `row.first` and writes those colours.
void SampleSharpRow(const Image<Rgb>& image, SourceRow& row, Rgb* out);

}  // namespace lamella
