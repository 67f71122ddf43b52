// A lens that spreads light by a Gaussian, and the pixels that it falls on. Light is spread before
// there are pixels: pixels that are spread have aliases of the edges in them, at 1 px corners are
// found 0.008 px aside by where between pixels they are. So it comes in half pixels, kSide x kSide
// of which are a pixel.
#pragma once

#include <vector>

#include "lightfield/image.h"

namespace lamella {

class LensSpread {
 public:
  static constexpr int kSide = 2;

  explicit LensSpread(double sigma_px);  // above 0, in whole pixels; cut off at 4 of it

  int reach() const { return static_cast<int>(weights_.size()) - 1; }  // in half pixels

  // Each direction by itself; at the borders the picture goes on as it ends. Along x a row of half
  // pixels becomes `width` pixels.
  void AlongX(const Rgb* half_pixels, int width, Rgb* pixels) const;
  // Along y row `y` of the pixels of a picture of `height` rows of half the height comes of those
  // within reach: `rows` has them, its first being the picture's row `first`.
  void AlongY(const Image<Rgb>& rows, int first, int height, int y, Rgb* pixels) const;

 private:
  // Of the half pixels m steps beyond the pixel's own two, to either side: the Gaussian's mean over
  // the two. The sum of both sides is 1.
  std::vector<float> weights_;
};

}  // namespace lamella
