// Scenes of textured rectangles, rendered ray by ray: pictures and depth that no code under test
// made.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "lightfield/image.h"
#include "lightfield/view.h"

namespace lamella::synthetic {

// The points origin + a u + b v with |a| <= half_u, |b| <= half_v (u, v unit vectors), with a
// smooth random texture whose finest detail is `detail` long, or grey where `textured` is false.
struct Panel {
  Eigen::Vector3d origin, u, v;
  double half_u = 0, half_v = 0;
  double detail = 1;
  int seed = 0;
  bool textured = true;
};

struct Picture {
  Image<Rgb8> image;
  Image<float> depth;  // along the optical axis at the pixel's centre; 0 where nothing is seen
};

// 4 x 4 rays per pixel; where nothing is seen, black.
Picture Render(const std::vector<Panel>& panels, const Camera& camera,
               const Rigid& camera_from_world);

// A camera at `centre` that looks at `target`, x to the right, y down (up is -y of the world).
Rigid LookAt(const Eigen::Vector3d& centre, const Eigen::Vector3d& target);
Camera Pinhole(int width, int height, double focal_px);

// A regular grid of rows x columns views of `size` pixels, `baseline` apart, whose disparity is 0
// at depth `zero_depth`; `every` rows and columns apart on the full grid. Views look along +z from
// z = 0.
std::vector<View> MakeGrid(int rows, int columns, int size, double focal_px, double baseline,
                           double zero_depth, int every = 1);

}  // namespace lamella::synthetic
