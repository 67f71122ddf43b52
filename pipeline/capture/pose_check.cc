#include "pipeline/capture/pose_check.h"

#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {

void CheckCamera(const Camera& camera, const std::string& where) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(where, what, "mend the camera");
  };
  constexpr int kMaxSize = 1 << 20;
  if (camera.width < 1 || camera.height < 1 || camera.width > kMaxSize ||
      camera.height > kMaxSize) {
    refuse(fmt::format("has an image size of {}x{} px", camera.width, camera.height));
  }
  if (!(camera.fx > 0) || !(camera.fy > 0) || !std::isfinite(camera.fx) ||
      !std::isfinite(camera.fy)) {
    refuse("has a focal length that is not positive");
  }
  if (!std::isfinite(camera.cx) || !std::isfinite(camera.cy)) {
    refuse("has a principal point that is not finite");
  }
  for (const double k : camera.distortion) {
    if (!std::isfinite(k)) refuse("has a distortion that is not finite");
  }
}

Eigen::Quaterniond CheckedRotation(const Eigen::Matrix3d& matrix, const std::string& where) {
  if (matrix.determinant() < 0) {
    throw InputError(where, "has a pose that mirrors (determinant below 0)",
                     "turn or flip two axes together, never one");
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (!matrix.allFinite() || (matrix - rotation).norm() > 1e-3) {
    throw InputError(where, "has a pose whose 3x3 part is no rotation", "mend the pose");
  }
  return Eigen::Quaterniond(rotation).normalized();
}

}  // namespace lamella
