// Outlines of dark, connected regions: the first step to markers and chessboards.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

// Darker than the middle between the darkest and the brightest pixel of its surroundings (within 16
// to 32 px), where those differ by `least_contrast` or more (the threshold of AprilTag, Olson
// 2011).
Image<std::uint8_t> DarkPixels(ImageSpan<const float> grey, float least_contrast);

// A connected region (by sides, not by corners): the ends of its rows and columns, on pixels'
// edges.
struct Region {
  int x = 0, y = 0, width = 0, height = 0;  // px
  int area = 0;
  std::vector<Eigen::Vector2d> outline;
};
// Those at least `least_side_px` wide and high.
std::vector<Region> ConnectedRegions(const Image<std::uint8_t>& dark, int least_side_px);

// Corners of a convex quadrilateral, clockwise as the picture is seen.
using Quad = std::array<Eigen::Vector2d, 4>;
// The quadrilateral that the region's outline is, its sides fitted to it; nothing where the outline
// is none.
std::optional<Quad> FitQuad(const Region& region);

}  // namespace lamella
