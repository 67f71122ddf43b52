#include "calibration/vignetting.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kCells = kGainColumns * kGainRows;
constexpr int kVignettingTerms = 3;
constexpr int kLeastViews = 3;
constexpr double kRelativeError = 1e-3;
constexpr double kMostFalloffSd = 0.1, kMostGainSd = 0.01;

// Columns: the vignetting's terms, then per layer its fall-off and its cells.
struct Columns {
  int num_layers;
  Index size() const { return kVignettingTerms + num_layers * (1 + kCells); }
  Index Falloff(int layer) const { return kVignettingTerms + layer * Index{1 + kCells}; }
  Index Cell(int layer, int cell) const { return Falloff(layer) + 1 + cell; }
};

VectorXd RowOf(const CellReading& reading, const Columns& columns) {
  VectorXd row = VectorXd::Zero(columns.size());
  double power = 1;
  for (Index i = 0; i < kVignettingTerms; ++i) row(i) = power *= reading.radius2;
  row(columns.Falloff(reading.layer)) = std::log(reading.cosine);
  row(columns.Cell(reading.layer, reading.cell)) = 1;
  return row;
}

void CheckViews(const std::vector<CellReading>& readings, int num_layers,
                const std::string& display) {
  for (int layer = 0; layer < num_layers; ++layer) {
    std::set<int> views;
    for (const CellReading& reading : readings) {
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

LayerEvenness LayerOf(const VectorXd& solution, const MatrixXd& covariance, const Columns& columns,
                      int layer) {
  LayerEvenness of;
  of.falloff = solution(columns.Falloff(layer));
  of.falloff_sd = std::sqrt(covariance(columns.Falloff(layer), columns.Falloff(layer)));
  double sum = 0;
  for (int cell = 0; cell < kCells; ++cell) {
    of.gains.push_back(std::exp(solution(columns.Cell(layer, cell))));
    sum += of.gains.back();
  }
  for (double& gain : of.gains) gain *= kCells / sum;
  // Against the layer's mean: its own level is no matter of evenness.
  const Index first = columns.Cell(layer, 0);
  const MatrixXd block = covariance.block(first, first, kCells, kCells);
  const VectorXd means = block.rowwise().mean();
  for (Index cell = 0; cell < kCells; ++cell) {
    const double variance = block(cell, cell) - 2 * means(cell) + means.mean();
    of.largest_gain_sd = std::max(of.largest_gain_sd, std::sqrt(std::max(0.0, variance)));
  }
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

Evenness FitEvenness(const std::vector<CellReading>& readings, int num_layers,
                     const std::string& display) {
  CheckViews(readings, num_layers, display);
  const Columns columns{num_layers};
  MatrixXd information = MatrixXd::Zero(columns.size(), columns.size());
  VectorXd right = VectorXd::Zero(columns.size());
  const auto usable = [](const CellReading& r) { return r.light > 0 && r.cosine > 0; };
  for (const CellReading& reading : readings) {
    if (!usable(reading)) continue;
    const double weight =
        1 / (reading.variance / (reading.light * reading.light) + kRelativeError * kRelativeError);
    const VectorXd row = RowOf(reading, columns);
    information += weight * row * row.transpose();
    right += weight * std::log(reading.light) * row;
  }
  // What nothing is known of gets a large deviation rather than none.
  information.diagonal().array() += 1e-2;
  const Eigen::LDLT<MatrixXd> factors(information);
  const VectorXd solution = factors.solve(right);
  const MatrixXd covariance =
      factors.solve(MatrixXd::Identity(information.rows(), information.cols()));
  Evenness evenness;
  evenness.vignetting.assign(solution.data(), solution.data() + kVignettingTerms);
  std::set<int> seen;
  double sum = 0, count = 0;
  for (const CellReading& reading : readings) {
    if (!usable(reading)) continue;
    seen.insert(reading.layer);
    const double residual = std::log(reading.light) - RowOf(reading, columns).dot(solution);
    sum += residual * residual;
    ++count;
  }
  evenness.rms = count > 0 ? std::sqrt(sum / count) : 0;
  for (int layer = 0; layer < num_layers; ++layer) {
    LayerEvenness of;
    if (seen.contains(layer)) {
      of = LayerOf(solution, covariance, columns, layer);
      CheckKnown(of, layer, display);
    }
    evenness.layers.push_back(std::move(of));
  }
  return evenness;
}

}  // namespace lamella
