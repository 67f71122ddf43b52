// Markers of marker_dictionary.h in a photograph, wherever and however they lie.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/dark_regions.h"
#include "lightfield/image.h"

namespace lamella {

struct FoundMarker {
  int id = 0;
  bool mirrored = false;
  // Top left, top right, bottom right, bottom left of the marker as it was drawn; to about half a
  // pixel.
  Quad corners;
};

// `grey` holds numbers of any response in which black and white differ by `least_contrast` or more.
// Black markers on white, with sides of 12 px or more.
std::vector<FoundMarker> FindMarkers(ImageSpan<const float> grey, float least_contrast);

// From the unit square's corners (0,0), (1,0), (1,1), (0,1) to a quadrilateral's.
Eigen::Matrix3d HomographyFromUnitSquare(const Quad& quad);

}  // namespace lamella
