// Pictures for a page: smaller, colour-coded, as text.
#pragma once

#include <string>
#include <vector>

#include "depth/resize_area.h"
#include "lightfield/depth_map.h"
#include "lightfield/image.h"

namespace lamella {

// sRGB codes, at most max_width wide (the mean of each pixel's area in linear light).
Image<Rgb8> PageCodes(ImageSpan<const Rgb> linear, int max_width);
// Of a picture whose rows are asked for from the top on (ResizeAreaDownwards).
Image<Rgb8> PageCodes(int width, int height, const RowOf& row_of, int max_width);

// "data:image/...;base64,..." of a PNG (format "png") or JPEG ("jpeg").
std::string DataUri(ImageSpan<const Rgb8> codes, const std::string& format, int jpeg_quality = 85);

// The same of an SVG's text.
std::string SvgDataUri(const std::string& svg);

// Inverse depths that get the first (far) and the last (near) colour of the scale; 1 / world units.
struct DepthScale {
  double far_inverse = 0, near_inverse = 1;
  double InverseAt(double share) const {
    return far_inverse + share * (near_inverse - far_inverse);
  }
};

// From the 1 % and 99 % quantiles of the maps' known depths; {0, 1} where nothing is known.
DepthScale ScaleOf(const std::vector<const DepthMap*>& maps);

// Colour of 0 (far, blue) to 1 (near, red): Turbo (A. Mikhailov, Google AI blog, 2019), its
// published polynomial.
Rgb8 DepthColor(double share);

// At most max_width wide, nearest pixels; unknown depth is a grey diagonal hatch, which no colour
// of the scale looks like.
Image<Rgb8> ColoredDepth(const DepthMap& map, const DepthScale& scale, int max_width);

// Share of the pixels whose depth is known.
double KnownShare(const DepthMap& map);

}  // namespace lamella
