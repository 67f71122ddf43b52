// The homography of a plane's points to a photograph, and the pose that it means.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "lightfield/rigid.h"

namespace lamella {

// The homography H with image ~ H (x, y, 1) of corresponding columns, of which up to 45 % may be
// wrong: least median of squares over samples of 4, then least squares on what agrees. Nothing
// where fewer than 4 points are given or they lie near a line. The same points give the same bits.
std::optional<Eigen::Matrix3d> FitHomography(const Eigen::Matrix2Xd& plane,
                                             const Eigen::Matrix2Xd& image);

// camera_from_plane of a homography into normalised image coordinates (x, y, 1) of a camera without
// distortion; the plane's origin lies in front.
Rigid PoseOfHomography(const Eigen::Matrix3d& normalised_from_plane);

}  // namespace lamella
