#include "lightfield/rigid.h"

#include <Eigen/SVD>

namespace lamella {

Eigen::Matrix<double, 3, 4> Rigid::Matrix() const {
  Eigen::Matrix<double, 3, 4> matrix;
  matrix << rotation.toRotationMatrix(), translation;
  return matrix;
}

Rigid operator*(const Rigid& c_from_b, const Rigid& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(), c_from_b * b_from_a.translation};
}

Rigid Inverse(const Rigid& b_from_a) {
  const Eigen::Quaterniond rotation = b_from_a.rotation.conjugate();
  return {rotation, rotation * -b_from_a.translation};
}

Eigen::Vector3d Centre(const Rigid& camera_from_world) {
  return Inverse(camera_from_world).translation;
}

Similarity AlignSimilarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const double n = static_cast<double>(from.cols());
  const Eigen::Vector3d from_mean = from.rowwise().mean();
  const Eigen::Vector3d to_mean = to.rowwise().mean();
  const Eigen::Matrix3Xd x = from.colwise() - from_mean;
  const Eigen::Matrix3Xd y = to.colwise() - to_mean;
  const Eigen::Matrix3d covariance = y * x.transpose() / n;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) sign.z() = -1;

  Similarity result;
  result.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  const double variance = x.squaredNorm() / n;
  result.scale = variance > 0 ? svd.singularValues().dot(sign) / variance : 1.0;
  result.translation = to_mean - result.scale * result.rotation * from_mean;
  return result;
}

}  // namespace lamella
