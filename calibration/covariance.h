// Covariances of a fit's parameters, from its normal equations.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/solve.h"

namespace lamella {

// Inverse of a symmetric matrix by a Cholesky decomposition of its scaled form; empty where it is
// not positive definite or has no finite inverse.
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& m);

// The Hessian of all parameters but the slips, with the slips eliminated (Schur's complement). A
// view of which no point counts is taken as known: it says nothing of anything else.
Eigen::MatrixXd WithoutSlips(const NormalEquations& equations, const Columns& columns);

// Covariance of all columns but the slips, times max(1, chi^2/dof). Empty where it has no finite
// value: the parameters' directions are then judged by Degeneracy.
Eigen::MatrixXd CovarianceOf(const Fit& fit);

}  // namespace lamella
