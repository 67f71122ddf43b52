// From photographs of Gray-code stripes to the panel's or projector's point that every pixel sees.
#pragma once

#include <vector>

#include "calibration/screen_map.h"
#include "lightfield/image.h"

namespace lamella {

// Of one panel or projector, seen without moving. In OpenCV's order (GrayCodePattern): the bits of
// the column from the most significant one on, each followed by its inverse; those of the row
// likewise; then white and black. A column's code is that of its cell of `cell_px`; bit i of it is
// white where bit i of (cell ^ cell >> 1) is set.
struct GrayCodeCapture {
  std::vector<ImageSpan<const float>> photos;  // numbers of any response
  int width_px = 0, height_px = 0;
  int cell_px = 1;

  int NumColumnBits() const;
  int NumRowBits() const;
  std::size_t NumPhotos() const;  // that are needed
};

// Every pixel sees the middle of its cell, with the standard deviation cell/sqrt(12). Valid are
// pixels of which every bit differs from its inverse by a quarter of white less black or more, and
// that by `least_contrast`. InputError where photographs are missing or differ in size.
ScreenMap DecodeGrayCode(const GrayCodeCapture& capture, double least_contrast = 0.05);

// The pattern of photo i.
Image<Rgb8> DrawGrayCode(const GrayCodeCapture& capture, std::size_t photo);

}  // namespace lamella
