#include "calibration/covariance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace lamella {

Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& m) {
  if (!(m.diagonal().minCoeff() > 0)) return {};
  const Eigen::VectorXd scale = m.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * m * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
  if (llt.info() != Eigen::Success) return {};
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(m.rows(), m.cols()));
  if (!inverse.allFinite()) return {};
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

Eigen::MatrixXd WithoutSlips(const NormalEquations& equations, const Columns& columns) {
  const int num = columns.first_slip;
  Eigen::MatrixXd reduced = equations.hessian.topLeftCorner(num, num);
  for (const int slip : columns.slip) {  // slips of different photographs never meet
    const Eigen::Matrix2d own = equations.hessian.block<2, 2>(slip, slip);
    const Eigen::MatrixXd cross = equations.hessian.block(0, slip, num, 2);
    reduced.noalias() -= cross * own.inverse() * cross.transpose();
  }
  for (int i = columns.num_display; i < num; ++i) {
    const double sd = columns.prior_sd[static_cast<std::size_t>(i)];
    if (!(equations.hessian(i, i) > 0)) reduced(i, i) = 1e6 / (sd * sd);
  }
  return reduced;
}

Eigen::MatrixXd CovarianceOf(const Fit& fit) {
  const Eigen::MatrixXd inverse = InverseOf(WithoutSlips(fit.equations, fit.columns));
  return std::max(1.0, fit.variance) * inverse;
}

}  // namespace lamella
