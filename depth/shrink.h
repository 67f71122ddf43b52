// Smaller pictures by area averaging.
#pragma once

#include "lightfield/image.h"

namespace lamella {

// Each pixel is the mean of the area that it covers, of codes; never larger than the input.
Image<Rgb8> ShrinkTo(ImageSpan<const Rgb8> image, int width, int height);

// 8-bit luma, of codes.
Image<std::uint8_t> LumaOf(ImageSpan<const Rgb8> image);

}  // namespace lamella
