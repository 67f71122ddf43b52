// What surfaces can be: shapes with an equation of their own, so that truth is exact, and meshes.
#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "datasets_synthetic/mesh.h"
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

using Shape = std::variant<Sphere, Parallelogram, std::shared_ptr<const Mesh>>;  // never null

// The smallest t in (t_min, t_max) where ray.origin + t ray.direction lies on the shape.
// (Meshes are asked through EmbreeMesh.)
std::optional<double> Intersect(const Sphere& sphere, const Ray& ray, double t_min, double t_max);
std::optional<double> Intersect(const Parallelogram& p, const Ray& ray, double t_min, double t_max);

// Empty for a mesh without vertices.
Eigen::AlignedBox3d BoundsOf(const Shape& shape);
// A point that moves with the shape: textures are laid out from it.
Eigen::Vector3d AnchorOf(const Shape& shape);

// What shading has to know of a point of a shape.
struct ShapePoint {
  Eigen::Vector3d face_normal;  // unit, of the surface itself; which of the two is up to the caller
  Eigen::Vector3d normal;       // unit, interpolated where a mesh has normals, else face_normal
  Eigen::Vector2d uv{0, 0};  // a parallelogram's (a, b), a mesh's texture coordinates, a sphere's
                             // longitude and latitude (from z towards x, up to y) over [0, 1]^2
  Eigen::Vector2d uv_per_length{0, 0};  // how fast u and v change along the surface, at most
};
// `triangle`: of a mesh, the one that `point` lies on.
ShapePoint PointOf(const Shape& shape, int triangle, const Eigen::Vector3d& point);

// The six faces of a box of the given full size, turned about its centre.
std::vector<Shape> Box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size,
                       const Eigen::Quaterniond& world_from_box);

}  // namespace lamella
