// How well views are predicted that a fit has not seen. calibration.md sections 6 and 7.
#pragma once

#include <vector>

#include "calibration/solve.h"

namespace lamella {

// Whitened squared residuals of the points that count, when cameras and display are known from
// three fourths of the views and only the poses and slips of the last fourth from itself. Every
// view is left out once; the order of the squares depends on views and points alone.
std::vector<double> HeldOutSquares(const Fit& fit, const Structure& structure,
                                   const Observations& observations);

// By how many standard errors the mean of such squares falls, point by point.
double GainInErrors(const std::vector<double>& before, const std::vector<double>& after);

}  // namespace lamella
