// Views: photographs with cameras and poses, and the sparse points that matching found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

struct GridPosition {
  int row = 0, column = 0;  // row 0 on top, column 0 left, as the camera array is seen from behind
  friend bool operator==(const GridPosition&, const GridPosition&) = default;
};

struct View {
  std::string name;             // its file's stem; unique
  std::filesystem::path image;  // undistorted: what `camera` (a pinhole after poses) describes
  Camera camera;
  Rigid camera_from_world;
  std::optional<GridPosition> grid;
  std::filesystem::path depth = {};  // EXR of depth that came with the capture; empty: none
};

// A triangulated point and the views (indices into ViewSet::views) that see it.
struct SparsePoint {
  Eigen::Vector3d position;
  std::vector<int> views;
};

// What the stage poses leaves: every view is posed. Sorted by name.
struct ViewSet {
  std::vector<View> views;
  std::vector<SparsePoint> points;  // empty for grids
};

// A rectified camera grid: all views share focal length and rotation, centres lie on a regular
// lattice in the image plane, and the principal points shift linearly with it, so that
//   a point at (x, y) in view (r, c) is at (x - d (c' - c), y - d (r' - r)) in view (r', c')
//   d = disparity_per_inverse_depth * (1/Z - inverse_depth_of_zero_disparity)         [px per step]
// (HCI light field benchmark). `step` is one row or column of the full grid: a 3x3 subset of rows
// and columns 0, 4, 8 keeps the numbers of the 9x9 grid.
struct RegularGrid {
  double disparity_per_inverse_depth = 0;      // B f, world units * px
  double inverse_depth_of_zero_disparity = 0;  // 1 / Zf
  double DisparityFromInverseDepth(double w) const {
    return disparity_per_inverse_depth * (w - inverse_depth_of_zero_disparity);
  }
  double InverseDepthFromDisparity(double d) const {
    return d / disparity_per_inverse_depth + inverse_depth_of_zero_disparity;
  }
};

// The grid of the views; nothing where they are not one (a missing grid position, other rotations,
// centres off the lattice by more than 1e-3 of a step, one view alone).
std::optional<RegularGrid> FindRegularGrid(const std::vector<View>& views);

}  // namespace lamella
