// A camera's pixel cut along the sides of the panels' pixels that it sees, so that the mean of what
// they show is a sum over the pieces.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace lamella {

// The coordinates on two panels, px of each, of a point of the camera's pixel.
using OnPanels = Eigen::Vector4d;

// Cuts a pixel, of whose corners, in turn, the coordinates are given, along the whole numbers of
// some of the coordinates (Sutherland and Hodgman 1974), which between corners are taken as linear:
// both of a panel, {0, 1} or {2, 3}, or all. Visits every piece with a point within it and its
// share of the area, as the first two of `axes` measure it; the shares sum to 1. False, and nothing
// visited, where the pixel is not convex on a panel or the pieces might be more than 64.
bool CutPixel(const std::array<OnPanels, 4>& corners, const std::vector<int>& axes,
              const std::function<void(const OnPanels& within, double share)>& visit);

}  // namespace lamella
