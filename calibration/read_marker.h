// Whether a marker stands where one is expected: what a search for all markers misses because it is
// small, blurred or faint can still be read at a place that is known.
#pragma once

#include <Eigen/Core>

#include "calibration/aruco_markers.h"
#include "lightfield/image.h"

namespace lamella {

// The marker's border is black within white, and at most two of its modules differ from `id`'s.
// `corners` are its top left, top right, bottom right and bottom left as drawn, exact to a third of
// a module; black and white of `grey` differ by `least_contrast` or more.
bool ShowsMarker(ImageSpan<const float> grey, const Quad& corners, int id, double least_contrast);

// From the unit square's corners (0,0), (1,0), (1,1), (0,1) to a quadrilateral's.
Eigen::Matrix3d HomographyFromUnitSquare(const Quad& quad);

}  // namespace lamella
