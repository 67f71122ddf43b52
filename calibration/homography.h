// The homography of a plane's points to a photograph, and the pose that it means.
#pragma once

#include <optional>
#include <vector>

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

// The focal length (px) of a camera with square pixels and its centre in the middle, from
// homographies of planes to its photographs: each says 1/f^2 twice (Zhang 2000), the better the
// more it is slanted; the weighted median of what they say. That of a normal lens, 1.3 times the
// longer side, where they are frontal and say nothing.
double FocalOfHomographies(const std::vector<Eigen::Matrix3d>& image_from_plane, int width,
                           int height);

}  // namespace lamella
