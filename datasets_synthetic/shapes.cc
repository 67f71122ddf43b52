#include "datasets_synthetic/shapes.h"

#include <cmath>

namespace lamella {
namespace {

using Eigen::Vector3d;

std::optional<double> IntersectSphere(const Sphere& sphere, const Ray& ray, double t_min,
                                      double t_max) {
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

std::optional<double> IntersectParallelogram(const Parallelogram& p, const Ray& ray, double t_min,
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

}  // namespace

std::optional<double> Intersect(const Shape& shape, const Ray& ray, double t_min, double t_max) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    return IntersectSphere(*sphere, ray, t_min, t_max);
  }
  return IntersectParallelogram(std::get<Parallelogram>(shape), ray, t_min, t_max);
}

Eigen::AlignedBox3d BoundsOf(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    const Vector3d r = Vector3d::Constant(sphere->radius);
    return {sphere->centre - r, sphere->centre + r};
  }
  const auto& p = std::get<Parallelogram>(shape);
  Eigen::AlignedBox3d box(p.corner);
  box.extend(p.corner + p.u);
  box.extend(p.corner + p.v);
  box.extend(p.corner + p.u + p.v);
  return box;
}

Vector3d NormalAt(const Shape& shape, const Vector3d& point) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    return (point - sphere->centre).normalized();
  }
  const auto& p = std::get<Parallelogram>(shape);
  return p.u.cross(p.v).normalized();
}

Vector3d AnchorOf(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->centre;
  return std::get<Parallelogram>(shape).corner;
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
