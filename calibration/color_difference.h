// How different two colours look.
#pragma once

#include <Eigen/Core>

namespace lamella {

struct Lab {
  double l = 0, a = 0, b = 0;
};

// CIE 1976 L*a*b* of linear light, Rec. 709 primaries, whose white (1, 1, 1) is the observer's.
Lab LabOf(const Eigen::Vector3d& light);

// CIEDE2000 with k_L = k_C = k_H = 1 (CIE 142-2001, as Sharma, Wu and Dalal 2005 write it).
double ColorDifference(const Lab& first, const Lab& second);

}  // namespace lamella
