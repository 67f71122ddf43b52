#include "calibration/vignetting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>
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
constexpr double kMostFalloffSd = 0.1, kMostGainSd = 0.01;

// EvennessColumns: the vignetting's terms, then per layer its fall-off and its cells.
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

LayerEvenness LayerOf(const VectorXd& solution, const MatrixXd& covariance,
                      const EvennessColumns& columns, int layer) {
  LayerEvenness of;
  of.gains = {kGainColumns, kGainRows, {}};
  of.falloff = solution(columns.Falloff(layer));
  of.falloff_sd = std::sqrt(covariance(columns.Falloff(layer), columns.Falloff(layer)));
  double sum = 0;
  for (int cell = 0; cell < kGainCells; ++cell) {
    of.gains.gains.push_back(std::exp(solution(columns.Cell(layer, cell))));
    sum += of.gains.gains.back();
  }
  for (double& gain : of.gains.gains) gain *= kGainCells / sum;
  // Against the layer's mean: its own level is no matter of evenness.
  const Index first = columns.Cell(layer, 0);
  const MatrixXd block = covariance.block(first, first, kGainCells, kGainCells);
  const VectorXd means = block.rowwise().mean();
  for (Index cell = 0; cell < kGainCells; ++cell) {
    const double variance = block(cell, cell) - 2 * means(cell) + means.mean();
    of.largest_gain_sd = std::max(of.largest_gain_sd, std::sqrt(std::max(0.0, variance)));
  }
  return of;
}

double WeightOf(const WhiteReading& reading) {
  const double relative = reading.variance / (reading.light * reading.light);
  return 1 / (relative + kRelativeWhiteError * kRelativeWhiteError);
}

struct SolvedEvenness {
  VectorXd solution;
  MatrixXd covariance;
  double rms = 0;
};

SolvedEvenness SolveEvenness(const std::vector<WhiteReading>& readings,
                             const EvennessColumns& columns) {
  MatrixXd information = MatrixXd::Zero(columns.size(), columns.size());
  VectorXd right = VectorXd::Zero(columns.size());
  for (const WhiteReading& reading : readings) {
    const VectorXd row = RowOf(reading, columns);
    information += WeightOf(reading) * row * row.transpose();
    right += WeightOf(reading) * std::log(reading.light) * row;
  }
  // What nothing is known of gets a large deviation rather than none.
  information.diagonal().array() += 1e-2;
  const Eigen::LDLT<MatrixXd> factors(information);
  SolvedEvenness solved{factors.solve(right),
                        factors.solve(MatrixXd::Identity(columns.size(), columns.size())), 0};
  double squares = 0, chi2 = 0;
  for (const WhiteReading& reading : readings) {
    const double residual = std::log(reading.light) - RowOf(reading, columns).dot(solved.solution);
    squares += residual * residual;
    chi2 += WeightOf(reading) * residual * residual;
  }
  const auto count = static_cast<double>(readings.size());
  const double freedom = std::max(1.0, count - static_cast<double>(columns.size()));
  solved.covariance *= std::max(1.0, chi2 / freedom);
  solved.rms = std::sqrt(squares / std::max(1.0, count));
  return solved;
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
      of = LayerOf(solved.solution, solved.covariance, columns, layer);
      CheckKnown(of, layer, display);
    }
    evenness.layers.push_back(std::move(of));
  }
  return evenness;
}

}  // namespace lamella
