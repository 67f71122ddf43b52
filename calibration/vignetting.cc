#include "calibration/vignetting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kGainCells = kGainColumns * kGainRows;
constexpr int kVignettingTerms = 3;
constexpr int kLeastViews = 3;
constexpr double kRelativeWhiteError = 1e-3;
constexpr double kMostGainSd = 0.01;
constexpr double kMostFalloffSd = 0.16;  // 1 % of the light 20 degrees aside

// The vignetting's terms, then per layer its fall-off and its cells.
struct EvennessColumns {
  int num_layers;
  Index size() const { return kVignettingTerms + num_layers * (1 + kGainCells); }
  Index Falloff(int layer) const { return kVignettingTerms + layer * Index{1 + kGainCells}; }
  Index Cell(int layer, int cell) const { return Falloff(layer) + 1 + cell; }
};

// Of the cells around a place, between whose middles the gain is bilinear. Beyond the outermost it
// goes on as it does inside, so that places near the border tell of these cells, too.
std::array<std::pair<int, double>, 4> WeightsAt(double x, double y) {
  const double u = x * kGainColumns - 0.5, v = y * kGainRows - 0.5;
  const int left = std::clamp(static_cast<int>(std::floor(u)), 0, kGainColumns - 2);
  const int top = std::clamp(static_cast<int>(std::floor(v)), 0, kGainRows - 2);
  const double s = u - left, t = v - top;
  const int cell = top * kGainColumns + left;
  return {{{cell, (1 - s) * (1 - t)},
           {cell + 1, s * (1 - t)},
           {cell + kGainColumns, (1 - s) * t},
           {cell + kGainColumns + 1, s * t}}};
}

VectorXd RowOf(const WhiteReading& reading, const EvennessColumns& columns) {
  VectorXd row = VectorXd::Zero(columns.size());
  double power = 1;
  for (Index i = 0; i < kVignettingTerms; ++i) row(i) = power *= reading.radius2;
  row(columns.Falloff(reading.layer)) = std::log(reading.cosine);
  for (const auto& [cell, weight] : WeightsAt(reading.x, reading.y)) {
    row(columns.Cell(reading.layer, cell)) += weight;
  }
  return row;
}

void CheckViews(const std::vector<WhiteReading>& readings, int num_layers,
                const std::string& display) {
  for (int layer = 0; layer < num_layers; ++layer) {
    std::set<int> views;
    for (const WhiteReading& reading : readings) {
      if (reading.layer == layer) views.insert(reading.view);
    }
    if (views.empty() || views.size() >= kLeastViews) continue;
    throw InputError(
        display,
        fmt::format("layer {}'s white is seen from {} direction{} only, which does not "
                    "tell vignetting from fall-off",
                    layer, views.size(), views.size() == 1 ? "" : "s"),
        "photograph it from 3 or more, straight and 20 degrees or more to the sides");
  }
}

double WeightOf(const WhiteReading& reading) {
  const double relative = reading.variance / (reading.light * reading.light);
  return 1 / (relative + kRelativeWhiteError * kRelativeWhiteError);
}

struct SolvedEvenness {
  VectorXd solution;
  MatrixXd covariance;  // of errors that every reading has for itself
  MatrixXd by_views;    // of errors that the readings of a view share
  double rms = 0;
};

// (1 - leverage)^(-1/2), by which the residuals of a view are as large as its errors; 0 where the
// view alone tells a direction, which then has no residual.
MatrixXd InverseRoot(const MatrixXd& leverage) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> of(leverage);
  const VectorXd root = of.eigenvalues().unaryExpr([](double share) {
    constexpr double kLeastLeft = 1e-4;
    return 1 - share > kLeastLeft ? 1 / std::sqrt(1 - share) : 0.0;
  });
  return of.eigenvectors() * root.asDiagonal() * of.eigenvectors().transpose();
}

// The covariance of a least-squares solution whose errors are alike within a view and independent
// between views: the bias-reduced sandwich "CR2" of Bell and McCaffrey (2002), times n/(n - 1) of n
// views, since it is 15 % small for 4 of them whose light is off as a whole. `rows` and `residuals`
// are whitened, `inverse` is that of rows^T rows.
MatrixXd CovarianceByViews(const MatrixXd& rows, const VectorXd& residuals,
                           const std::vector<WhiteReading>& readings, const MatrixXd& inverse) {
  std::map<int, std::vector<Index>> views;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    views[readings[i].view].push_back(static_cast<Index>(i));
  }
  MatrixXd covariance = MatrixXd::Zero(inverse.rows(), inverse.cols());
  for (const auto& [view, members] : views) {
    const MatrixXd of_view = rows(members, Eigen::all);
    const MatrixXd leverage = of_view * inverse * of_view.transpose();
    const VectorXd error = InverseRoot(leverage) * residuals(members);
    const VectorXd moved = inverse * (of_view.transpose() * error);
    covariance += moved * moved.transpose();
  }
  const auto count = static_cast<double>(views.size());
  return covariance * (count / std::max(1.0, count - 1));
}

SolvedEvenness SolveEvenness(const std::vector<WhiteReading>& readings,
                             const EvennessColumns& columns) {
  const auto count = static_cast<Index>(readings.size());
  MatrixXd rows(count, columns.size());
  VectorXd lights(count), roots(count);
  for (Index i = 0; i < count; ++i) {
    const WhiteReading& reading = readings[static_cast<std::size_t>(i)];
    roots(i) = std::sqrt(WeightOf(reading));
    rows.row(i) = roots(i) * RowOf(reading, columns).transpose();
    lights(i) = roots(i) * std::log(reading.light);
  }
  MatrixXd information = rows.transpose() * rows;
  // What nothing is known of gets a large deviation rather than none.
  information.diagonal().array() += 1e-2;
  const Eigen::LDLT<MatrixXd> factors(information);
  SolvedEvenness solved;
  solved.solution = factors.solve(rows.transpose() * lights);
  solved.covariance = factors.solve(MatrixXd::Identity(columns.size(), columns.size()));
  const VectorXd residuals = lights - rows * solved.solution;
  solved.by_views = CovarianceByViews(rows, residuals, readings, solved.covariance);
  const double freedom = std::max(1.0, static_cast<double>(count - columns.size()));
  solved.covariance *= std::max(1.0, residuals.squaredNorm() / freedom);
  solved.rms = std::sqrt(residuals.cwiseQuotient(roots).squaredNorm() /
                         std::max(1.0, static_cast<double>(count)));
  return solved;
}

// Of a layer's gains against their mean: its own level is no matter of evenness.
VectorXd GainVariances(const MatrixXd& covariance, Index first) {
  const MatrixXd block = covariance.block(first, first, kGainCells, kGainCells);
  const VectorXd means = block.rowwise().mean();
  return ((block.diagonal() - 2 * means).array() + means.mean()).max(0);
}

// The larger one of both deviations: a few views may by chance agree better than their readings.
// Of gains the views tell too little cell by cell: they tell by how much all of them are larger.
LayerEvenness LayerOf(const SolvedEvenness& solved, const EvennessColumns& columns, int layer) {
  LayerEvenness of;
  of.gains = {kGainColumns, kGainRows, {}};
  const Index falloff = columns.Falloff(layer), first = columns.Cell(layer, 0);
  of.falloff = solved.solution(falloff);
  of.falloff_sd =
      std::sqrt(std::max(solved.covariance(falloff, falloff), solved.by_views(falloff, falloff)));
  double sum = 0;
  for (Index cell = 0; cell < kGainCells; ++cell) {
    of.gains.gains.push_back(std::exp(solved.solution(first + cell)));
    sum += of.gains.gains.back();
  }
  for (double& gain : of.gains.gains) gain *= kGainCells / sum;
  const VectorXd alone = GainVariances(solved.covariance, first);
  const double shared = GainVariances(solved.by_views, first).sum() / alone.sum();
  of.largest_gain_sd = std::sqrt(alone.maxCoeff() * std::max(1.0, shared));
  return of;
}

void CheckKnown(const LayerEvenness& layer, int index, const std::string& display) {
  if (layer.falloff_sd <= kMostFalloffSd && layer.largest_gain_sd <= kMostGainSd) return;
  throw InputError(
      display,
      fmt::format("layer {}'s fall-off is known to {:.2g} and its evenness to {:.1f} % only", index,
                  layer.falloff_sd, 100 * layer.largest_gain_sd),
      "photograph white from directions that differ more, the panel at other places of the "
      "picture");
}

}  // namespace

double VignettingAt(const Evenness& evenness, double radius2) {
  double exponent = 0, power = 1;
  for (const double term : evenness.vignetting) exponent += term * (power *= radius2);
  return std::exp(exponent);
}

Evenness FitEvenness(const std::vector<WhiteReading>& readings, int num_layers,
                     const std::string& display) {
  CheckViews(readings, num_layers, display);
  std::vector<WhiteReading> usable;
  std::copy_if(readings.begin(), readings.end(), std::back_inserter(usable),
               [](const WhiteReading& r) { return r.light > 0 && r.cosine > 0; });
  const EvennessColumns columns{num_layers};
  const SolvedEvenness solved = SolveEvenness(usable, columns);
  Evenness evenness;
  evenness.vignetting.assign(solved.solution.data(), solved.solution.data() + kVignettingTerms);
  evenness.rms = solved.rms;
  for (int layer = 0; layer < num_layers; ++layer) {
    LayerEvenness of;
    if (std::any_of(usable.begin(), usable.end(),
                    [&](const WhiteReading& reading) { return reading.layer == layer; })) {
      of = LayerOf(solved, columns, layer);
      CheckKnown(of, layer, display);
    }
    evenness.layers.push_back(std::move(of));
  }
  return evenness;
}

}  // namespace lamella
