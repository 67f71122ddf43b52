// What a camera position from which nothing was photographed yet would tell: the common parts of
// next_view.h and next_plane_view.h. Information is the inverse of a covariance, of the cameras'
// and the display's columns (the first Columns::num_display).
#pragma once

#include <Eigen/Core>

#include "calibration/residuals.h"
#include "calibration/state.h"
#include "lightfield/rigid.h"

namespace lamella {

// Upright, looking at the origin.
Rigid LookingFrom(const Eigen::Vector3d& centre);
// At degrees to the right and up from the z axis, which the origin sees.
Eigen::Vector3d PlaceAt(double right_deg, double up_deg, double distance_mm);

// Of one view, its pose (where it is not known) and its slips eliminated.
Eigen::MatrixXd InformationOfView(const NormalEquations& equations, const Columns& columns);
// Of all photographs so far, with what a builder would assume (Columns::prior_sd); `variance` is
// their chi^2 per degree of freedom, which counts where it is above 1.
Eigen::MatrixXd InformationSoFar(const NormalEquations& equations, const Columns& columns,
                                 double variance);
Eigen::MatrixXd CovarianceOfInformation(const Eigen::MatrixXd& information);

}  // namespace lamella
