// From photographs of Gray-code stripes to the panel's or projector's point that every pixel sees.
#pragma once

#include <cstddef>
#include <functional>

#include "calibration/screen_map.h"
#include "lightfield/image.h"

namespace lamella {

// Of one panel or projector. In OpenCV's order (GrayCodePattern): the bits of the column from the
// most significant one on, each followed by its inverse; those of the row likewise; then white and
// black. A column's code is that of its cell of `cell_px`; bit i of it is white where bit i of
// (cell ^ cell >> 1) is set.
struct GrayCodePatterns {
  int width_px = 0, height_px = 0;
  int cell_px = 1;

  int NumColumnBits() const;
  int NumRowBits() const;
  std::size_t Count() const;
};

// Every pixel sees the middle of its cell, with the standard deviation cell/sqrt(12). Valid are
// pixels of which every bit differs from its inverse by a quarter of white less black or more, and
// white from black by `least_contrast`. `photo(i)` gives the photograph of pattern i, taken without
// moving, in numbers of any response; each is asked for once, white and black first, and no more
// than two are held. InputError where they differ in size.
ScreenMap DecodeGrayCode(const GrayCodePatterns& patterns,
                         const std::function<Image<float>(std::size_t)>& photo,
                         double least_contrast = 0.05);

// Share of the steps from cell to cell, along the photograph's rows or columns, that go the other
// way than the step before. Of a smooth surface 0. A pattern in its inverse's place is as clear as
// any and mirrors every 2^(i+1) cells, i its bit: then it is about 2^-i. Other orders make more.
double ShareOfStepsBack(const ScreenMap& map);

// Pattern i.
Image<Rgb8> DrawGrayCode(const GrayCodePatterns& patterns, std::size_t i);

}  // namespace lamella
