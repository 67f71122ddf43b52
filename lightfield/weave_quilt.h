// A quilt to the native image of a Looking Glass panel: every sub-pixel shows its own view
// (displays.md section 4).
#pragma once

#include <array>

#include "lightfield/image.h"
#include "lightfield/looking_glass.h"
#include "lightfield/quilt.h"

namespace lamella {

// What a sub-pixel of direction `view` in [0, 1] shows of N views. The nearest one is that of
// ViewIndex; linear goes from view i at view N = i to the next; the Gaussians weigh three views
// with sigma 1/2 and five with sigma 1, of views at (i + 1/2)/N. Nothing wraps: the first and the
// last view go on.
enum class ViewFilter { kNearest, kLinear, kGaussian, kWideGaussian };

struct ViewTaps {
  int count = 0;
  std::array<int, 5> views{};
  std::array<float, 5> weights{};  // sum to 1
};
ViewTaps TapsOf(double view, int views, ViewFilter filter);

// The panel's image. `views` of the quilt's tiles are used, 1 or more. Pictures are stretched to
// the panel (bilinear, in linear light, never across a tile's edge) where layout.aspect is within 1
// % of the panel's or is not known, else fitted into it with black bars. Flips of the calibration
// mirror the pictures.
Image<Rgb8> WeaveQuilt(ImageSpan<const Rgb8> quilt, const QuiltLayout& layout, int views,
                       const LookingGlass& calibration, ViewFilter filter);

}  // namespace lamella
