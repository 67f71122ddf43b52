// Cameras: from a point in front of the camera to a pixel and back, each with its Jacobian.
//
// Camera axes: x right, y down, z forward (OpenCV, COLMAP). Pixels: continuous coordinates, the
// first pixel's centre is (0.5, 0.5).
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace lamella {

enum class CameraModel {
  kPinhole,
  // Brown-Conrady with OpenCV's rational radial part; distortion = k1 k2 p1 p2 k3 k4 k5 k6:
  //   x' = x * (1 + k1 r2 + k2 r4 + k3 r6)/(1 + k4 r2 + k5 r4 + k6 r6) + 2 p1 x y + p2 (r2 + 2 x2)
  kBrown,
  // Equidistant with theta_d = theta (1 + k1 t2 + k2 t4 + k3 t6 + k4 t8); distortion = k1 k2 k3 k4
  kFisheye,
};

struct Camera {
  CameraModel model = CameraModel::kPinhole;
  int width = 0, height = 0;              // px
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  std::array<double, 8> distortion{};     // unused ones are 0

  // fx, fy, cx, cy, then the distortion: the order of the columns of PixelJacobian::parameters.
  static constexpr int kNumParameters = 12;
};

struct PixelJacobian {
  Eigen::Matrix<double, 2, 3> point;
  Eigen::Matrix<double, 2, Camera::kNumParameters> parameters;
};

// The pixel of a point given in the camera's frame; nothing where the point is not in front of the
// camera (z <= 0; a fisheye sees all but the axis behind).
std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& point,
                                       PixelJacobian* jacobian = nullptr);

// The direction (x, y, 1) seen by a pixel (unit vector for a fisheye); nothing where the distortion
// can't be inverted there. `jacobian` is d(direction)/d(pixel).
std::optional<Eigen::Vector3d> Unproject(const Camera& camera, const Eigen::Vector2d& pixel,
                                         Eigen::Matrix<double, 3, 2>* jacobian = nullptr);

// The same view with its images resized by `scale` (pixel-area convention: c -> scale * c).
// Width and height are rounded and the focal lengths follow the rounded size exactly.
Camera Resized(const Camera& camera, double scale);

}  // namespace lamella
