// Where photographs of a generated scene are taken from.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

// The camera at `centre` that looks at `target`, with `up` upwards in its picture (camera axes: x
// right, y down, z forward).
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

}  // namespace lamella
