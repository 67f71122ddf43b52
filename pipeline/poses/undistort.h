// Photographs without the distortion of their lenses: what a pinhole camera would have seen.
#pragma once

#include <optional>

#include "lightfield/camera.h"
#include "lightfield/image.h"

namespace lamella {

// The pinhole camera of the undistorted image: the size of the original, or of `longer_side_px`
// where that is given and smaller; the focal length of the original (scaled with the size), raised
// by just so much that no pixel sees beyond the original's edge.
Camera UndistortedCamera(const Camera& camera, int longer_side_px = 0);

// Rows [first_row, first_row + rows.height) of what `pinhole` sees, where `image` is seen by
// `camera`, which looks the same way. Catmull-Rom in
// linear light, widened where the result is smaller, so that it does not alias. Where `pinhole`
// sees beyond the image, its edge is repeated.
void UndistortRows(const Image<Rgb>& image, const Camera& camera, const Camera& pinhole,
                   int first_row, ImageSpan<Rgb> rows);

// A pixel of the distorted image in the undistorted one; nothing where the distortion can't be
// inverted there.
std::optional<Eigen::Vector2d> UndistortPixel(const Camera& camera, const Camera& pinhole,
                                              const Eigen::Vector2d& pixel);

}  // namespace lamella
