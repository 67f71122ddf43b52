// What a varifocal display's planes are calibrated for: which pixel of a plane a line of sight
// meets. Lines go from every eye of the box through 7 x 5 pixels of every plane, edge to edge, and
// stand still in the frame; calibration.md sections 6 and 7.
#pragma once

#include <Eigen/Core>

#include "calibration/uncertainty.h"
#include "calibration/varifocal_solve.h"

namespace lamella {

// RMS change of the pixels from `a`, whose pixels the lines go through, to `b`.
double ChangeOfRays(const VarifocalState& a, const VarifocalState& b, const VarifocalTask& task,
                    const EyeBox& box);

// Standard deviations of the pixels, of the length of their error; of a covariance of all columns
// but the slips (CovarianceOf). A ray's panel is the plane's, its pixel the plane's own.
RayUncertainty UncertaintyOfRays(const VarifocalFit& fit, const VarifocalTask& task,
                                 const Rigid& display_from_frame, const Eigen::MatrixXd& covariance,
                                 const EyeBox& box);

}  // namespace lamella
