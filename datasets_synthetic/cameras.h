// Where photographs of a generated scene are taken from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/camera.h"
#include "lightfield/options.h"
#include "lightfield/rigid.h"
#include "lightfield/view.h"

namespace lamella {

// The camera at `centre` that looks at `target`, with `up` upwards in its picture (camera axes: x
// right, y down, z forward). Where it looks along `up`, some direction across is upwards.
Rigid LookAt(const Eigen::Vector3d& centre, const Eigen::Vector3d& target,
             const Eigen::Vector3d& up);

// A person's walk along an arc about `target`, in a world with y up: even steps, with the
// unsteadiness of a hand in place, aim and tilt.
struct HandheldArc {
  Eigen::Vector3d target{0, 0, 0};
  double radius = 3;            // world units
  double height = 0.5;          // above the target
  double angle_deg = 32;        // from the first to the last view; the middle one looks along -z
  double place_jitter = 0.05;   // standard deviation, share of the radius
  double aim_jitter_deg = 1.2;  // standard deviation
  double roll_jitter_deg = 1.5;
};
std::vector<Rigid> CamerasOnArc(const HandheldArc& arc, int num_views, std::uint32_t seed);

// Cameras before a scene, in a world with y up. The middle one stands `height` above the target and
// `distance` from it towards +z, and looks at it.
struct CameraLayout {
  // handheld       a walk along an arc, unsteady in place, aim and tilt
  // arc            the same with a steady hand
  // line           along the middle camera's x axis
  // grid           rows and columns across the middle camera's axis; row 0 on top, column 0 left
  // jittered-grid  the same, out of place by a share of the spacing
  // dome           spread evenly over a cap of the sphere about the target
  std::string layout = "handheld";
  int views = 14;             // a grid's: a square number, unless rows or columns are given
  int rows = 0, columns = 0;  // 0: follows from views
  // What lines and grids are aimed at. off-axis: parallel axes, each picture shifted on the sensor
  // so that the plane through the target coincides in all; converged: all axes meet at the target;
  // parallel: neither.
  std::string aim = "off-axis";
  Eigen::Vector3d target{0, 0, 0};
  double distance = 3.7;        // world units, horizontal
  double height = 0.75;         // world units
  double angle_deg = 30;        // arcs: first to last view; dome: across the cap
  double spacing = 0.1;         // world units from camera to camera of lines and grids
  double place_jitter = 0.012;  // standard deviation: handheld share of distance, grid of spacing
  double aim_jitter_deg = 1.2;  // standard deviation, handheld
  double roll_jitter_deg = 1.5;
  int width_px = 960, height_px = 0;  // of the photographs; height 0: three quarters of the width
  double focal_per_width = 1.05;      // focal length / width; a moderate telephoto, 51 degrees
};
// All but the target, as the table [cameras] of a recipe.
OptionTable Describe(CameraLayout& layout);

// The cameras in order, named view_001 and so on; `grid` is set in a grid, `image` is not. The same
// for a seed everywhere. UsageError naming `where` where a grid's views fill no rectangle.
std::vector<View> CamerasOf(const CameraLayout& layout, std::uint32_t seed,
                            const std::string& where = {});

}  // namespace lamella
