// Rigid transforms, named to_from_from and composed so that the names meet:
//   camera_from_model = camera_from_world * world_from_model
#pragma once

#include <Eigen/Geometry>

namespace lamella {

struct Rigid {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
  Eigen::Matrix<double, 3, 4> Matrix() const;
};

Rigid operator*(const Rigid& c_from_b, const Rigid& b_from_a);
Rigid Inverse(const Rigid& b_from_a);
// Where the camera is: the world point that camera_from_world sends to the origin.
Eigen::Vector3d Centre(const Rigid& camera_from_world);

// y = scale * rotation * x + translation.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation;
  }
};

// The least-squares similarity from the columns of `from` to those of `to` (Umeyama 1991).
// Needs 3 columns that are not on a line for a unique answer; 3 x n both.
Similarity AlignSimilarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

}  // namespace lamella
