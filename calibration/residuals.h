// Residuals of all photographs and their normal equations. calibration.md section 5.
//
// A point's residual is L^T (predicted - measured) with L L^T the inverse of its covariance; a
// photograph's slip d adds d/tau. problem-inl.h has them as Ceres takes them.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "calibration/state.h"

namespace lamella {

// Which points count and how.
struct Weighting {
  std::vector<std::vector<char>> inlier;  // per photograph and point; empty: all are
  double cauchy = 0;         // width b of the loss b^2 log(1 + r^2/b^2); 0: least squares
  double slip_sd_px = 0.03;  // tau
};

// The whitened residuals, 2 x points, of each photograph; large where a point lies behind its
// camera.
std::vector<Eigen::Matrix2Xd> WhitenedResiduals(const CalibrationState& state,
                                                const Structure& structure,
                                                const Observations& observations);

// Sum of squares of the points that count, its gradient and Gauss-Newton Hessian in the columns'
// tangent space; without a loss, which would make deviations look larger than they are.
struct NormalEquations {
  Eigen::MatrixXd hessian;   // J^T J
  Eigen::VectorXd gradient;  // J^T r
  double cost = 0;           // |r|^2
};
NormalEquations Linearise(const CalibrationState& state, const Structure& structure,
                          const Columns& columns, const Observations& observations,
                          const Weighting& weighting);

}  // namespace lamella
