#include "calibration/slip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>

namespace lamella {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kSmallestPx = 0.001, kLargestPx = 0.3;

// The data's share of the normal equations, without any prior on slips; other parameters are scaled
// to a unit diagonal, which changes the probability by a constant factor only.
struct DataEquations {
  Eigen::MatrixXd others;                // Hessian
  std::vector<Eigen::MatrixXd> crossed;  // per slip, others x 2
  std::vector<Matrix2d> own;
  Eigen::VectorXd gradient;
  std::vector<Vector2d> own_gradient, slip;
};

DataEquations WithoutPrior(const SlipSolution& fit) {
  const int num = fit.num_others;
  const double tau = fit.slip_sd_px;
  const Eigen::MatrixXd& hessian = fit.equations.hessian;
  const double certain = 1 / std::max(1e-12, fit.variance);
  Eigen::VectorXd scale = hessian.diagonal().head(num).cwiseSqrt();
  for (double& s : scale) s = s > 0 ? 1 / s : 0;
  DataEquations data;
  data.others =
      certain * (scale.asDiagonal() * hessian.topLeftCorner(num, num) * scale.asDiagonal());
  for (int i = 0; i < num; ++i) {
    if (!(scale(i) > 0)) data.others(i, i) = 1;
  }
  data.gradient = certain * scale.asDiagonal() * fit.equations.gradient.head(num);
  for (std::size_t i = 0; i < fit.columns.size(); ++i) {
    const int at = fit.columns[i];
    const Matrix2d own = hessian.block<2, 2>(at, at) - Matrix2d::Identity() / (tau * tau);
    if (!(own.trace() > 1e-6 / (tau * tau))) continue;  // no point of it counts
    const Vector2d slip = fit.slips_px[i];
    data.own.push_back(certain * own);
    data.crossed.push_back(certain * scale.asDiagonal() * hessian.block(0, at, num, 2));
    data.own_gradient.push_back(certain *
                                (fit.equations.gradient.segment<2>(at) - slip / (tau * tau)));
    data.slip.push_back(slip);
  }
  return data;
}

// -2 log of the restricted likelihood of tau, but for a constant.
double Improbability(const DataEquations& data, double tau) {
  const double prior = 1 / (tau * tau);
  Eigen::MatrixXd reduced = data.others;
  Eigen::VectorXd gradient = data.gradient;
  double sum = 0;
  for (std::size_t i = 0; i < data.own.size(); ++i) {
    const Matrix2d own = data.own[i] + prior * Matrix2d::Identity();
    const Vector2d g = data.own_gradient[i] + prior * data.slip[i];
    const Eigen::MatrixXd gain = data.crossed[i] * own.inverse();
    reduced.noalias() -= gain * data.crossed[i].transpose();
    gradient.noalias() -= gain * g;
    sum += std::log(own.determinant()) + 4 * std::log(tau) + prior * data.slip[i].squaredNorm() -
           g.dot(own.inverse() * g);
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(reduced);
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd root = llt.matrixL().solve(gradient);
  sum -= root.squaredNorm();
  for (Eigen::Index i = 0; i < reduced.rows(); ++i) sum += 2 * std::log(llt.matrixLLT()(i, i));
  return sum;
}

}  // namespace

double EstimateSlip(const SlipSolution& solution) {
  const DataEquations data = WithoutPrior(solution);
  constexpr int kCoarse = 10;
  const double low = std::log(kSmallestPx), high = std::log(kLargestPx);
  const double step = (high - low) / (kCoarse - 1);
  const auto cost = [&](double log_tau) { return Improbability(data, std::exp(log_tau)); };
  double best = low, least = cost(low);
  for (int i = 1; i < kCoarse; ++i) {
    const double value = cost(low + i * step);
    if (value < least) {
      least = value;
      best = low + i * step;
    }
  }
  // Three times halved around the best, to 6 %.
  for (double width = step / 2; width > 0.06; width /= 2) {
    for (const double at : {best - width, best + width}) {
      const double value =
          at >= low && at <= high ? cost(at) : std::numeric_limits<double>::infinity();
      if (value < least) {
        least = value;
        best = at;
      }
    }
  }
  return std::exp(best);
}

}  // namespace lamella
