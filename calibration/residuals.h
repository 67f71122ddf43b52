// Residuals of all photographs and their normal equations. calibration.md section 5.
//
// A point's residual is L^T (predicted - measured) with L L^T the inverse of its covariance; a
// photograph's slip d adds d/tau.
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

// sum of losses, its gradient and Gauss-Newton Hessian in the columns' tangent space (with a loss:
// of iteratively reweighted least squares).
struct NormalEquations {
  Eigen::MatrixXd hessian;   // J^T W J
  Eigen::VectorXd gradient;  // J^T W r
  double cost = 0;           // sum of rho(|r|^2)
};
NormalEquations Linearise(const CalibrationState& state, const Structure& structure,
                          const Columns& columns, const Observations& observations,
                          const Weighting& weighting);

// The whitened residuals, 2 x points, of each photograph; large where a point lies behind its
// camera.
std::vector<Eigen::Matrix2Xd> WhitenedResiduals(const CalibrationState& state,
                                                const Structure& structure,
                                                const Observations& observations);
double Cost(const CalibrationState& state, const Structure& structure,
            const Observations& observations, const Columns& columns, const Weighting& weighting);

// The photograph's pixel that the state predicts for a panel's pixel, and its derivatives by the
// parameters of the photograph: camera 9, view 6, stack 6, relation 6, shape 4, index, plate,
// slip 2 (all seen as free).
constexpr int kPhotoColumns = 35;
struct Prediction {
  Eigen::Vector2d image_px;
  Eigen::Matrix<double, 2, kPhotoColumns> jacobian;
};
std::vector<Prediction> Predict(const CalibrationState& state, const Structure& structure,
                                const Observations& observations, std::size_t photo);

}  // namespace lamella
