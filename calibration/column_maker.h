// Columns of a tangent space, handed out in their order with names, units and what a display's
// builder would assume of them.
#pragma once

#include <string>

#include "calibration/state.h"

namespace lamella {

struct ColumnMaker {
  Columns& columns;

  // Each returns the first column that it adds.
  int Next(const std::string& name, double prior_sd, const std::string& unit);
  int Pose(const std::string& of, double angle_sd, double shift_sd);
  // Focal lengths, centre, k1, k2, p1, p2 and, where asked for, k3.
  int Camera(const std::string& name, bool k3);
};

}  // namespace lamella
