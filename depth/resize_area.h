// Pictures resized by the area filter: every new pixel is the mean of what it covers. In linear
// light, in the pixel-area convention (c -> scale * c).
#pragma once

#include "lightfield/image.h"

namespace lamella {

// width, height >= 1. Enlarging repeats pixels (with mixed ones on the borders).
Image<Rgb> ResizeArea(ImageSpan<const Rgb> image, int width, int height);

}  // namespace lamella
