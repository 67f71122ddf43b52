// What every reader of known cameras refuses.
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "lightfield/camera.h"

namespace lamella {

// InputError naming `where`: a size below 1 px or above 2^20, a focal length that is not positive,
// a number that is not finite.
void CheckCamera(const Camera& camera, const std::string& where);

// The rotation nearest to the matrix; InputError where it mirrors (a single flipped axis) or is no
// rotation within 1e-3.
Eigen::Quaterniond CheckedRotation(const Eigen::Matrix3d& matrix, const std::string& where);

}  // namespace lamella
