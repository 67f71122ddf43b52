#include "depth/bundle_map.h"

#include <limits>

namespace lamella {

Eigen::Matrix4d WorldFromBundle(const RayBundle& bundle) {
  const bool point = bundle.centre.w() != 0;
  const Eigen::Vector3d centre = point
                                     ? Eigen::Vector3d(bundle.centre.head<3>() / bundle.centre.w())
                                     : bundle.centre.head<3>();
  Eigen::Matrix4d matrix;
  matrix.col(0) << bundle.dx, 0;
  matrix.col(1) << bundle.dy, 0;
  if (point) {
    matrix.col(2) << bundle.origin - centre, 0;
    matrix.col(3) << centre, 1;
  } else {
    matrix.col(2) << bundle.origin, 1;
    matrix.col(3) << centre, 0;
  }
  return matrix;
}

Eigen::Matrix4d CountedFrom(double zero, const Eigen::Matrix4d& world_from_bundle) {
  Eigen::Matrix4d counted = world_from_bundle;
  counted.col(2) += zero * counted.col(3);
  return counted;
}

Eigen::Matrix4d ViewFromWorld(const Camera& camera, const Rigid& camera_from_world) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  matrix.topRows<3>() = k * camera_from_world.Matrix();
  matrix(3, 3) = 1;
  return matrix;
}

DistanceFromNearness::DistanceFromNearness(const RayBundle& bundle, double zero)
    : is_point_(bundle.centre.w() != 0), zero_(zero) {
  const Eigen::Vector3d normal = bundle.Normal();
  scale_ = is_point_ ? (bundle.centre.head<3>() / bundle.centre.w() - bundle.origin).dot(normal)
                     : bundle.centre.head<3>().dot(normal);
}

float DistanceFromNearness::operator()(float nearness) const {
  const double n = static_cast<double>(nearness);
  if (!is_point_) return static_cast<float>(scale_ * (zero_ + n));
  // X = C + (P - C) / n.
  const double whole = zero_ + n;
  if (!(whole > 0)) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(scale_ * ((zero_ - 1) + n) / whole);
}

LocalMap::LocalMap(const Eigen::Matrix4d& map, double at_a, double at_b, double at_c) {
  const Eigen::Vector4d at(at_a, at_b, 1, at_c);
  const Eigen::Vector4d out = map * at;
  // Behind the viewer there is no point to expand around; the plain map is used.
  const bool front = out.z() > 0;
  const double x = front ? out.x() / out.z() : 0, y = front ? out.y() / out.z() : 0;
  const double size = (map.row(2).array() * at.transpose().array()).abs().sum();
  const double scale = front ? 1 / out.z() : size > 0 ? 1 / size : 1;
  const auto f = [](double v) { return static_cast<float>(v); };
  const Eigen::RowVector4d row_x = scale * (map.row(0) - x * map.row(2));
  const Eigen::RowVector4d row_y = scale * (map.row(1) - y * map.row(2));
  const Eigen::RowVector4d row_m = scale * map.row(2), row_q = scale * map.row(3);
  x0 = f(x), y0 = f(y);
  x_0 = front ? 0 : f(row_x * at), xa = f(row_x[0]), xb = f(row_x[1]), xc = f(row_x[3]);
  y_0 = front ? 0 : f(row_y * at), ya = f(row_y[0]), yb = f(row_y[1]), yc = f(row_y[3]);
  m0 = f(row_m * at), ma = f(row_m[0]), mb = f(row_m[1]), mc = f(row_m[3]);
  q_0 = f(row_q[0] * at_a + row_q[1] * at_b + row_q[2]);
  qa = f(row_q[0]), qb = f(row_q[1]), qc = f(row_q[3]);
}

}  // namespace lamella
