#include "calibration/imagined_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "calibration/covariance.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

// The columns behind the first `num` eliminated.
MatrixXd FirstColumns(const MatrixXd& joint, Eigen::Index num) {
  const Eigen::Index others = joint.rows() - num;
  if (others == 0) return joint;
  const MatrixXd cross = joint.topRightCorner(num, others);
  const MatrixXd own = joint.bottomRightCorner(others, others);
  return joint.topLeftCorner(num, num) - cross * own.ldlt().solve(cross.transpose());
}

}  // namespace

Rigid LookingFrom(const Vector3d& centre) {
  const Vector3d forward = -centre.normalized();
  const Vector3d right = forward.cross(Vector3d::UnitY()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  return {Eigen::Quaterniond(rotation), -(rotation * centre)};
}

Vector3d PlaceAt(double right_deg, double up_deg, double distance_mm) {
  const double yaw = right_deg * std::numbers::pi / 180, pitch = up_deg * std::numbers::pi / 180;
  return distance_mm * Vector3d(std::tan(yaw), std::tan(pitch), 1).normalized();
}

MatrixXd InformationOfView(const NormalEquations& equations, const Columns& columns) {
  return FirstColumns(WithoutSlips(equations, columns), columns.num_display);
}

MatrixXd InformationSoFar(const NormalEquations& equations, const Columns& columns,
                          double variance) {
  MatrixXd joint = WithoutSlips(equations, columns) / std::max(1.0, variance);
  for (Eigen::Index i = 0; i < joint.rows(); ++i) {
    const double sd = columns.prior_sd[static_cast<std::size_t>(i)];
    joint(i, i) += 1 / (sd * sd);
  }
  return FirstColumns(joint, columns.num_display);
}

MatrixXd CovarianceOfInformation(const MatrixXd& information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  return scale.asDiagonal() *
         scaled.ldlt().solve(MatrixXd::Identity(scaled.rows(), scaled.cols())) * scale.asDiagonal();
}

}  // namespace lamella
