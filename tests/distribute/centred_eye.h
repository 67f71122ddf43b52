// An eye before the middle of a picture on z = 0.
#pragma once

#include <Eigen/Core>

#include "distribute/simulate_eye.h"

namespace lamella {

inline Eye CentredEye(const Eigen::Vector3d& position, double pixel_mm, int width, int height) {
  Eye eye;
  eye.position = position;
  eye.left_mm = -width / 2.0 * pixel_mm;
  eye.top_mm = height / 2.0 * pixel_mm;
  eye.pixel_mm = pixel_mm;
  eye.width = width;
  eye.height = height;
  return eye;
}

}  // namespace lamella
