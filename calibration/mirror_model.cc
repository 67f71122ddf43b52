#include "calibration/mirror_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

#include "lightfield/varifocal.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kNumbers = 7, kDepth = 5, kMagnification = 6, kMostHarmonics = 3;
constexpr double kMostByChance = 4;  // standard deviations

// Generalised least squares, columns scaled so that angles and mm are alike.
struct LinearFit {
  VectorXd coefficients, deviations;
  MatrixXd covariance;
  double chi2 = 0;
  int freedom = 0;

  bool Holds() const { return chi2 <= freedom + kMostByChance * std::sqrt(2.0 * freedom); }
};

std::optional<LinearFit> FitLinear(const MatrixXd& model, const VectorXd& numbers,
                                   const MatrixXd& covariance) {
  if (!(covariance.diagonal().minCoeff() > 0) || model.cols() >= model.rows()) return std::nullopt;
  const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::LLT<MatrixXd> llt(scaled);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const MatrixXd white = llt.matrixL().solve(scale.asDiagonal() * model);
  const VectorXd white_numbers = llt.matrixL().solve(scale.asDiagonal() * numbers);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(white);
  LinearFit fit;
  fit.coefficients = qr.solve(white_numbers);
  fit.deviations = numbers - model * fit.coefficients;
  fit.chi2 = (white_numbers - white * fit.coefficients).squaredNorm();
  fit.freedom = static_cast<int>(model.rows() - model.cols());
  fit.covariance = (white.transpose() * white).inverse();
  return fit;
}

MatrixXd HarmonicsOf(const std::vector<double>& phases, int harmonics) {
  const auto num = static_cast<Eigen::Index>(phases.size());
  MatrixXd model = MatrixXd::Zero(kNumbers * num, kNumbers * (harmonics + 1));
  for (Eigen::Index k = 0; k < num; ++k) {
    for (int j = 0; j <= harmonics; ++j) {
      const double value = std::cos(j * phases[static_cast<std::size_t>(k)]);
      for (int i = 0; i < kNumbers; ++i) model(kNumbers * k + i, kNumbers * j + i) = value;
    }
  }
  return model;
}

// RMS of every kNumbers-th entry from `first`.
double RmsOf(const VectorXd& numbers, int first) {
  const auto num = numbers.size() / kNumbers;
  return std::sqrt(Eigen::VectorXd(numbers(Eigen::seqN(first, num, kNumbers))).squaredNorm() /
                   static_cast<double>(num));
}

void FindWorst(const MatrixXd& covariance, MirrorModel& model) {
  double largest = -1;
  for (std::size_t k = 0; k < model.deviations.size(); ++k) {
    const auto at = kNumbers * static_cast<Eigen::Index>(k);
    const Eigen::Matrix<double, kNumbers, kNumbers> own = covariance.block<7, 7>(at, at);
    const double chi2 = model.deviations[k].dot(own.ldlt().solve(model.deviations[k]));
    if (!(chi2 > largest)) continue;
    largest = chi2;
    model.worst_plane = static_cast<int>(k);
    model.worst_depth_mm = model.deviations[k](kDepth);
  }
}

// M on z. Both are measured: the covariance of M - z/f is used, with the f found so far.
void FitRelay(const VectorXd& numbers, const MatrixXd& covariance, MirrorModel& model) {
  const auto num = numbers.size() / kNumbers;
  const auto depths = Eigen::seqN(kDepth, num, kNumbers);
  const auto magnifications = Eigen::seqN(kMagnification, num, kNumbers);
  MatrixXd line = MatrixXd::Ones(num, 2);
  line.col(1) = numbers(depths);
  const MatrixXd zz = covariance(depths, depths), mz = covariance(magnifications, depths);
  const MatrixXd mm = covariance(magnifications, magnifications);
  std::optional<LinearFit> fit;
  double power = 0;
  for (int round = 0; round < 4; ++round) {
    const MatrixXd of_both = mm - power * (mz + mz.transpose()) + power * power * zz;
    fit = FitLinear(line, numbers(magnifications), of_both);
    if (!fit) return;
    power = fit->coefficients(1);
  }
  model.relay_holds = fit->Holds();
  model.magnification0 = fit->coefficients(0);
  model.relay_power_per_mm = power;
  model.magnification0_sd = std::sqrt(fit->covariance(0, 0));
  model.relay_power_sd = std::sqrt(fit->covariance(1, 1));
  model.relay_chi2 = fit->chi2;
  model.relay_freedom = fit->freedom;
}

}  // namespace

std::vector<double> MirrorPhases(const Varifocal& varifocal) {
  // The membrane that has K equal times' middles at both ends of the planes.
  const int planes = varifocal.planes;
  const double reach = std::cos(std::numbers::pi / (2 * planes));
  std::vector<double> phases;
  for (const double z : PlaneDepthsMm(varifocal)) {
    phases.push_back(std::acos(-reach * z / (varifocal.depth_mm / 2)));
  }
  return phases;
}

MirrorModel FitMirrorModel(const std::vector<PlaneNumbers>& numbers, const MatrixXd& covariance,
                           const std::vector<double>& phases) {
  MirrorModel model;
  const auto size = kNumbers * static_cast<Eigen::Index>(numbers.size());
  VectorXd all(size);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    all.segment<kNumbers>(kNumbers * static_cast<Eigen::Index>(k)) = numbers[k];
  }
  std::optional<LinearFit> best;
  double least = 0;
  for (int harmonics = 1; harmonics <= kMostHarmonics; ++harmonics) {
    const auto fit = FitLinear(HarmonicsOf(phases, harmonics), all, covariance);
    if (!fit) break;
    const double bic = fit->chi2 + static_cast<double>(fit->coefficients.size()) *
                                       std::log(static_cast<double>(size));
    if (best && bic >= least) continue;
    least = bic;
    best = fit;
    model.harmonics = harmonics;
  }
  if (!best) return model;
  model.tested = true;
  model.chi2 = best->chi2;
  model.freedom = best->freedom;
  model.holds = best->Holds();
  const VectorXd sd = covariance.diagonal().cwiseSqrt();
  model.depth_rms_mm = RmsOf(best->deviations, kDepth);
  model.depth_sd_mm = RmsOf(sd, kDepth);
  model.magnification_rms = RmsOf(best->deviations, kMagnification);
  model.magnification_sd = RmsOf(sd, kMagnification);
  for (Eigen::Index k = 0; k < size; k += kNumbers) {
    model.deviations.emplace_back(best->deviations.segment<kNumbers>(k));
  }
  FindWorst(covariance, model);
  FitRelay(all, covariance, model);
  return model;
}

}  // namespace lamella
