// What a varifocal display's planes are calibrated for: which pixel of a plane a line of sight
// meets. Lines go from every eye of the box through 7 x 5 pixels of every plane, edge to edge, and
// stand still in the frame; calibration.md sections 6 and 7.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/uncertainty.h"
#include "calibration/varifocal_solve.h"

namespace lamella {

// A ray's panel is the plane's, its pixel the plane's own; plane by plane, eye by eye, pixels row
// by row from the top left.
std::vector<ProbedRay> RaysThroughPlanes(const std::vector<PanelCalibration>& planes,
                                         const EyeBox& box);

// RMS change of the pixels from `a`, whose pixels the lines go through, to `b`.
double ChangeOfRays(const VarifocalState& a, const VarifocalState& b, const VarifocalTask& task,
                    const EyeBox& box);

// Standard deviations of the pixels of RaysThroughPlanes, of the length of their error; of a
// covariance of all columns but the slips (CovarianceOf).
RayUncertainty UncertaintyOfRays(const VarifocalFit& fit, const VarifocalTask& task,
                                 const Rigid& display_from_frame, const Eigen::MatrixXd& covariance,
                                 const EyeBox& box);

}  // namespace lamella
