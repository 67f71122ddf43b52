#include "lightfield/camera.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using DistortionJacobian = Eigen::Matrix<double, 2, 8>;

// Brown-Conrady, normalised coordinates to distorted ones.
Vector2d DistortBrown(const std::array<double, 8>& k, const Vector2d& u, Matrix2d* d_u,
                      DistortionJacobian* d_k) {
  const double x = u.x(), y = u.y();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double numerator = 1 + k[0] * r2 + k[1] * r4 + k[4] * r6;
  const double denominator = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  const double radial = numerator / denominator;
  const double p1 = k[2], p2 = k[3];
  if (d_u != nullptr) {
    const double d_numerator = k[0] + 2 * k[1] * r2 + 3 * k[4] * r4;
    const double d_denominator = k[5] + 2 * k[6] * r2 + 3 * k[7] * r4;
    const double slope =
        2 * (d_numerator - radial * d_denominator) / denominator;  // d radial/d r2 * 2
    (*d_u)(0, 0) = radial + x * slope * x + 2 * p1 * y + 6 * p2 * x;
    (*d_u)(0, 1) = x * slope * y + 2 * p1 * x + 2 * p2 * y;
    (*d_u)(1, 0) = y * slope * x + 2 * p2 * y + 2 * p1 * x;
    (*d_u)(1, 1) = radial + y * slope * y + 2 * p2 * x + 6 * p1 * y;
  }
  if (d_k != nullptr) {
    const Vector2d by_numerator = u / denominator;
    const Vector2d by_denominator = -radial / denominator * u;
    d_k->col(0) = by_numerator * r2;
    d_k->col(1) = by_numerator * r4;
    d_k->col(2) = Vector2d(2 * x * y, r2 + 2 * y * y);
    d_k->col(3) = Vector2d(r2 + 2 * x * x, 2 * x * y);
    d_k->col(4) = by_numerator * r6;
    d_k->col(5) = by_denominator * r2;
    d_k->col(6) = by_denominator * r4;
    d_k->col(7) = by_denominator * r6;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
}

// Equidistant fisheye, theta to theta_d.
double DistortAngle(const std::array<double, 8>& k, double theta, double* d_theta) {
  const double t2 = theta * theta, t4 = t2 * t2, t6 = t4 * t2, t8 = t4 * t4;
  if (d_theta != nullptr)
    *d_theta = 1 + 3 * k[0] * t2 + 5 * k[1] * t4 + 7 * k[2] * t6 + 9 * k[3] * t8;
  return theta * (1 + k[0] * t2 + k[1] * t4 + k[2] * t6 + k[3] * t8);
}

Vector2d ProjectFisheye(const Camera& camera, const Vector3d& p, PixelJacobian* jacobian) {
  const double r = std::hypot(p.x(), p.y());
  const double theta = std::atan2(r, p.z());
  double d_theta = 1;
  const double theta_d = DistortAngle(camera.distortion, theta, &d_theta);
  // On the axis theta_d / r -> d_theta / z.
  const bool axis = r < 1e-12 * std::abs(p.z());
  const double q = axis ? d_theta / p.z() : theta_d / r;
  const Vector2d direction(p.x(), p.y());
  if (jacobian != nullptr) {
    const double n2 = p.squaredNorm();
    Eigen::Matrix<double, 2, 3> m;
    if (axis) {
      m << q, 0, 0, 0, q, 0;
    } else {
      const double dq_dr = (d_theta * p.z() / n2 - q) / r;  // d(theta_d/r)/dr along the plane
      m.leftCols<2>() = q * Matrix2d::Identity() + direction * direction.transpose() * (dq_dr / r);
      m.col(2) = direction * (-d_theta / n2);
    }
    jacobian->point = Vector2d(camera.fx, camera.fy).asDiagonal() * m;
    jacobian->parameters.setZero();
    jacobian->parameters(0, 0) = q * p.x();
    jacobian->parameters(1, 1) = q * p.y();
    jacobian->parameters(0, 2) = jacobian->parameters(1, 3) = 1;
    double power = theta * theta * theta;
    for (int i = 0; i < 4; ++i, power *= theta * theta) {
      const Vector2d d = axis ? Vector2d(Vector2d::Zero()) : Vector2d(direction * (power / r));
      jacobian->parameters(0, 4 + i) = camera.fx * d.x();
      jacobian->parameters(1, 4 + i) = camera.fy * d.y();
    }
  }
  return {camera.fx * q * p.x() + camera.cx, camera.fy * q * p.y() + camera.cy};
}

// Newton's method from the distorted coordinates; the model's inverse has no closed form.
std::optional<Vector2d> UndistortBrown(const Camera& camera, const Vector2d& distorted,
                                       Matrix2d* d_u) {
  Vector2d u = distorted;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Vector2d error = DistortBrown(camera.distortion, u, d_u, nullptr) - distorted;
    const double determinant = d_u->determinant();
    if (!(determinant > 1e-9)) return std::nullopt;  // folded over
    const Vector2d step = d_u->inverse() * error;
    u -= step;
    if (step.norm() < 1e-14 * (1 + u.norm())) return u;
  }
  const Vector2d error = DistortBrown(camera.distortion, u, d_u, nullptr) - distorted;
  if (error.norm() > 1e-10 || d_u->determinant() < 1e-9) return std::nullopt;
  return u;
}

std::optional<Vector3d> UnprojectFisheye(const Camera& camera, const Vector2d& pixel,
                                         Eigen::Matrix<double, 3, 2>* jacobian) {
  const Vector2d m((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  const double theta_d = m.norm();
  double theta = theta_d, slope = 1;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const double error = DistortAngle(camera.distortion, theta, &slope) - theta_d;
    if (!(slope > 1e-9)) return std::nullopt;
    theta -= error / slope;
    if (std::abs(error) < 1e-14) break;
  }
  if (!(theta <= 3.1415926535897932) || theta < 0) return std::nullopt;
  const double s = theta_d > 1e-12 ? std::sin(theta) / theta_d : 1.0;
  if (jacobian != nullptr) {
    Eigen::Matrix<double, 3, 2> d;
    if (theta_d > 1e-12) {
      const double d_s = (std::cos(theta) / slope - s) / theta_d;
      d.topRows<2>() = s * Matrix2d::Identity() + m * m.transpose() * (d_s / theta_d);
      d.row(2) = -std::sin(theta) / slope / theta_d * m.transpose();
    } else {
      d << 1, 0, 0, 1, 0, 0;
    }
    *jacobian = d * Vector2d(1 / camera.fx, 1 / camera.fy).asDiagonal();
  }
  return Vector3d(s * m.x(), s * m.y(), std::cos(theta));
}

}  // namespace

std::optional<Vector2d> Project(const Camera& camera, const Vector3d& point,
                                PixelJacobian* jacobian) {
  if (camera.model == CameraModel::kFisheye) {
    if (point.x() == 0 && point.y() == 0 && point.z() <= 0) return std::nullopt;
    return ProjectFisheye(camera, point, jacobian);
  }
  if (!(point.z() > 0)) return std::nullopt;
  const Vector2d u(point.x() / point.z(), point.y() / point.z());
  const bool brown = camera.model == CameraModel::kBrown;
  Matrix2d d_u = Matrix2d::Identity();
  DistortionJacobian d_k = DistortionJacobian::Zero();
  const Vector2d v = brown ? DistortBrown(camera.distortion, u, jacobian ? &d_u : nullptr,
                                          jacobian ? &d_k : nullptr)
                           : u;
  if (jacobian != nullptr) {
    Eigen::Matrix<double, 2, 3> d_point;
    d_point << 1 / point.z(), 0, -u.x() / point.z(), 0, 1 / point.z(), -u.y() / point.z();
    const Vector2d focal(camera.fx, camera.fy);
    jacobian->point = focal.asDiagonal() * d_u * d_point;
    jacobian->parameters.setZero();
    jacobian->parameters(0, 0) = v.x();
    jacobian->parameters(1, 1) = v.y();
    jacobian->parameters(0, 2) = jacobian->parameters(1, 3) = 1;
    jacobian->parameters.rightCols<8>() = focal.asDiagonal() * d_k;
  }
  return Vector2d(camera.fx * v.x() + camera.cx, camera.fy * v.y() + camera.cy);
}

std::optional<Vector3d> Unproject(const Camera& camera, const Vector2d& pixel,
                                  Eigen::Matrix<double, 3, 2>* jacobian) {
  if (camera.model == CameraModel::kFisheye) return UnprojectFisheye(camera, pixel, jacobian);
  const Vector2d distorted((pixel.x() - camera.cx) / camera.fx,
                           (pixel.y() - camera.cy) / camera.fy);
  Matrix2d d_u = Matrix2d::Identity();
  std::optional<Vector2d> u = distorted;
  if (camera.model == CameraModel::kBrown) u = UndistortBrown(camera, distorted, &d_u);
  if (!u) return std::nullopt;
  if (jacobian != nullptr) {
    jacobian->setZero();
    jacobian->topRows<2>() = d_u.inverse() * Vector2d(1 / camera.fx, 1 / camera.fy).asDiagonal();
  }
  return Vector3d(u->x(), u->y(), 1);
}

Camera Resized(const Camera& camera, double scale) {
  Camera resized = camera;
  resized.width = std::max(1, static_cast<int>(std::lround(camera.width * scale)));
  resized.height = std::max(1, static_cast<int>(std::lround(camera.height * scale)));
  const double sx = static_cast<double>(resized.width) / camera.width;
  const double sy = static_cast<double>(resized.height) / camera.height;
  resized.fx *= sx;
  resized.cx *= sx;
  resized.fy *= sy;
  resized.cy *= sy;
  return resized;
}

}  // namespace lamella
