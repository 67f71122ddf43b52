#include "datasets_synthetic/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

ShapePoint PointOfSphere(const Sphere& sphere, const Vector3d& point) {
  ShapePoint found;
  const Vector3d n = (point - sphere.centre).normalized();
  found.face_normal = found.normal = n;
  const double pi = std::numbers::pi;
  found.uv = {0.5 + std::atan2(n.x(), n.z()) / (2 * pi),
              0.5 + std::asin(std::clamp(n.y(), -1.0, 1.0)) / pi};
  const double ring = std::max(std::hypot(n.x(), n.z()), 1e-9);  // of unit radius
  found.uv_per_length = Vector2d(0.5 / ring, 1) / (pi * sphere.radius);
  return found;
}

// w = a u + b v + what is across; the gradients of a and b have the inverse heights' lengths.
ShapePoint PointOfParallelogram(const Parallelogram& p, const Vector3d& point) {
  ShapePoint found;
  const Vector3d normal = p.u.cross(p.v), within = point - p.corner;
  const double n2 = normal.squaredNorm();
  found.face_normal = found.normal = normal.normalized();
  found.uv = {within.cross(p.v).dot(normal) / n2, p.u.cross(within).dot(normal) / n2};
  found.uv_per_length = Vector2d(p.v.norm(), p.u.norm()) / std::sqrt(n2);
  return found;
}

ShapePoint PointOfMesh(const Mesh& mesh, int triangle, const Vector3d& point) {
  ShapePoint found;
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto i = static_cast<std::size_t>(t.x()), j = static_cast<std::size_t>(t.y()),
             k = static_cast<std::size_t>(t.z());
  const Vector3d e1 = mesh.vertices[j] - mesh.vertices[i], e2 = mesh.vertices[k] - mesh.vertices[i];
  const Vector3d normal = e1.cross(e2), within = point - mesh.vertices[i];
  const double n2 = normal.squaredNorm();
  const Vector3d grad_b = e2.cross(normal) / n2, grad_c = normal.cross(e1) / n2;
  const double b = within.dot(grad_b), c = within.dot(grad_c);  // weights of the corners j and k
  found.face_normal = found.normal = normal.normalized();
  if (!mesh.normals.empty()) {
    const Vector3d mean = (1 - b - c) * mesh.normals[i] + b * mesh.normals[j] + c * mesh.normals[k];
    if (const double length = mean.norm(); length > 1e-6) found.normal = mean / length;
    if (found.normal.dot(found.face_normal) < 0) found.normal = -found.normal;
  }
  if (!mesh.texture_coordinates.empty()) {
    const Vector2d& uv = mesh.texture_coordinates[i];
    const Vector2d db = mesh.texture_coordinates[j] - uv, dc = mesh.texture_coordinates[k] - uv;
    found.uv = uv + b * db + c * dc;
    found.uv_per_length = {(db.x() * grad_b + dc.x() * grad_c).norm(),
                           (db.y() * grad_b + dc.y() * grad_c).norm()};
  }
  return found;
}

}  // namespace

std::optional<double> Intersect(const Sphere& sphere, const Ray& ray, double t_min, double t_max) {
  // From the point of the ray that is closest to the centre, which keeps all digits however far
  // away the ray starts.
  const double length2 = ray.direction.squaredNorm();
  const double t_closest = (sphere.centre - ray.origin).dot(ray.direction) / length2;
  const Vector3d closest = ray.origin + t_closest * ray.direction - sphere.centre;
  const double half2 = sphere.radius * sphere.radius - closest.squaredNorm();
  if (!(half2 >= 0)) return std::nullopt;
  const double half = std::sqrt(half2 / length2);
  for (const double t : {t_closest - half, t_closest + half}) {
    if (t > t_min && t < t_max) return t;
  }
  return std::nullopt;
}

std::optional<double> Intersect(const Parallelogram& p, const Ray& ray, double t_min,
                                double t_max) {
  const Vector3d normal = p.u.cross(p.v);
  const double slope = normal.dot(ray.direction);
  if (slope == 0) return std::nullopt;
  const double t = normal.dot(p.corner - ray.origin) / slope;
  if (!(t > t_min && t < t_max)) return std::nullopt;
  const Vector3d within = ray.origin + t * ray.direction - p.corner;
  const double n2 = normal.squaredNorm();
  const double a = within.cross(p.v).dot(normal) / n2;
  const double b = p.u.cross(within).dot(normal) / n2;
  if (!(a >= 0 && a <= 1 && b >= 0 && b <= 1)) return std::nullopt;
  return t;
}

Eigen::AlignedBox3d BoundsOf(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    const Vector3d r = Vector3d::Constant(sphere->radius);
    return {sphere->centre - r, sphere->centre + r};
  }
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&shape)) return BoundsOf(**mesh);
  const auto& p = std::get<Parallelogram>(shape);
  Eigen::AlignedBox3d box(p.corner);
  box.extend(p.corner + p.u);
  box.extend(p.corner + p.v);
  box.extend(p.corner + p.u + p.v);
  return box;
}

Vector3d AnchorOf(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->centre;
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&shape)) {
    return (*mesh)->vertices.empty() ? Vector3d(0, 0, 0) : (*mesh)->vertices.front();
  }
  return std::get<Parallelogram>(shape).corner;
}

ShapePoint PointOf(const Shape& shape, int triangle, const Vector3d& point) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return PointOfSphere(*sphere, point);
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&shape)) {
    return PointOfMesh(**mesh, triangle, point);
  }
  return PointOfParallelogram(std::get<Parallelogram>(shape), point);
}

std::vector<Shape> Box(const Vector3d& centre, const Vector3d& size,
                       const Eigen::Quaterniond& world_from_box) {
  const Eigen::Matrix3d axes = world_from_box.toRotationMatrix() * size.asDiagonal();
  const Vector3d low = centre - 0.5 * (axes.col(0) + axes.col(1) + axes.col(2));
  std::vector<Shape> faces;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d u = axes.col((axis + 1) % 3), v = axes.col((axis + 2) % 3);
    faces.push_back(Parallelogram{low, u, v});
    faces.push_back(Parallelogram{low + axes.col(axis), u, v});
  }
  return faces;
}

}  // namespace lamella
