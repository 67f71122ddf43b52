// OpenCV's markers and boards, in this project's pixels. The one place that knows OpenCV's
// versions: 4.6 has them in its module aruco, 4.7 and later in objdetect.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

// The dictionary is OpenCV's DICT_5X5_1000.
inline constexpr int kNumMarkers = 1000;
inline constexpr int kMarkerModules = 5;      // a side, without the black border
inline constexpr int kMarkerSideModules = 7;  // with it

// Bit i + 5 j is module (i, j), from the top left, set where it is white.
using MarkerBits = std::uint32_t;
MarkerBits BitsOfMarker(int id);

// Corners of a quadrilateral.
using Quad = std::array<Eigen::Vector2d, 4>;

struct FoundMarker {
  int id = 0;
  // Top left, top right, bottom right, bottom left of the marker as it was drawn; to about half a
  // pixel.
  Quad corners;
};
// cv::aruco::detectMarkers in the picture as it is, or, for markers that are seen by reflection,
// in its mirror image (other ids would be read from the picture itself); corners are those of the
// picture. Black markers with sides of 12 px or more. MachineError where this OpenCV does not find
// its own markers where it draws them (tested once, on a small board).
std::vector<FoundMarker> FindMarkers(ImageSpan<const std::uint8_t> grey, bool mirrored);

// cv::aruco::CharucoBoard: whole squares, the first one black, markers in the white ones row by row
// from `first_id`.
Image<std::uint8_t> DrawCharuco(int columns, int rows, int square_px, int marker_px, int first_id);

}  // namespace lamella
