// Pictures resized by the area filter: every new pixel is the mean of what it covers. In linear
// light, in the pixel-area convention (c -> scale * c).
#pragma once

#include <functional>

#include "lightfield/image.h"

namespace lamella {

// width, height >= 1. Enlarging repeats pixels (with mixed ones on the borders).
Image<Rgb> ResizeArea(ImageSpan<const Rgb> image, int width, int height);

// The same of a picture in another form: row(y, buffer) gives its row y, which may be written to
// `buffer` (image_width long) for that. Called from many threads.
using RowOf = std::function<const Rgb*(int y, Rgb* buffer)>;
Image<Rgb> ResizeArea(int image_width, int image_height, const RowOf& row, int width, int height);
// By one thread, which asks for the rows from the top on and for none but the last one again.
Image<Rgb> ResizeAreaDownwards(int image_width, int image_height, const RowOf& row, int width,
                               int height);

}  // namespace lamella
