// Surfaces with an equation of their own, so that truth is exact.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "lightfield/ray_source.h"

namespace lamella {

struct Sphere {
  Eigen::Vector3d centre;
  double radius = 1;
};

// corner + a u + b v with a, b in [0, 1]; seen from both sides.
struct Parallelogram {
  Eigen::Vector3d corner, u, v;
};

using Shape = std::variant<Sphere, Parallelogram>;

// The smallest t in (t_min, t_max) where ray.origin + t ray.direction lies on the shape.
std::optional<double> Intersect(const Shape& shape, const Ray& ray, double t_min, double t_max);

Eigen::AlignedBox3d BoundsOf(const Shape& shape);
// Unit normal at a point of the shape; which of the two is up to the caller.
Eigen::Vector3d NormalAt(const Shape& shape, const Eigen::Vector3d& point);
// A point that moves with the shape: textures are laid out from it.
Eigen::Vector3d AnchorOf(const Shape& shape);

// The six faces of a box of the given full size, turned about its centre.
std::vector<Shape> Box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size,
                       const Eigen::Quaterniond& world_from_box);

}  // namespace lamella
