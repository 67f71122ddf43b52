#include "calibration/response_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRelativeError = 1e-3;  // of a reading: flicker and drift of lamp and shutter
constexpr int kNumKnots = 33;
constexpr int kIterations = 20;  // Gauss-Newton from values that are nearly right takes 4

// No reading is exact, not even a black one without noise: numbers have 16 bits at best.
constexpr double kLeastVariance = 1.0 / 12 / 65535 / 65535 / 2000;  // of a mean of 2000 px

double WeightOf(const FlatReading& reading) {
  const double relative = kRelativeError * reading.light;
  return 1 / (reading.variance + relative * relative + kLeastVariance);
}

std::size_t ToSize(int value) { return static_cast<std::size_t>(value); }

// Readings sorted into levels and exposures.
struct Table {
  const std::vector<FlatReading>& readings;
  std::vector<double> codes;          // rising, the last one 1
  std::vector<std::size_t> level_of;  // of each reading
  int num_exposures = 0;
};

Table Sorted(const std::vector<FlatReading>& readings, const std::string& panel) {
  Table table{readings, {}, {}, 0};
  for (const FlatReading& reading : readings) {
    table.codes.push_back(reading.code);
    table.num_exposures = std::max(table.num_exposures, reading.exposure + 1);
  }
  std::sort(table.codes.begin(), table.codes.end());
  table.codes.erase(std::unique(table.codes.begin(), table.codes.end()), table.codes.end());
  if (table.codes.size() < 5 || table.codes.front() != 0 || table.codes.back() != 1) {
    throw InputError(panel, "its response needs black, white and three levels between",
                     "take the photographs of them that are missing or overexposed");
  }
  for (const FlatReading& reading : readings) {
    const auto at = std::lower_bound(table.codes.begin(), table.codes.end(), reading.code);
    table.level_of.push_back(static_cast<std::size_t>(at - table.codes.begin()));
  }
  return table;
}

struct Levels {
  VectorXd light;     // of every level, white 1
  VectorXd gain;      // of every exposure; 0: without readings
  VectorXd variance;  // of `light`
};

// The gain of an exposure from the levels that are known already, weighted; nothing where they do
// not stand out of the noise.
std::optional<double> GainOf(const Table& table, int exposure,
                             const std::vector<std::optional<double>>& known) {
  double product = 0, square = 0;
  for (std::size_t i = 0; i < table.readings.size(); ++i) {
    const FlatReading& reading = table.readings[i];
    const std::optional<double>& light = known[table.level_of[i]];
    if (reading.exposure != exposure || !light) continue;
    product += WeightOf(reading) * *light * reading.light;
    square += WeightOf(reading) * *light * *light;
  }
  constexpr double kLeastSignal = 10;  // standard deviations
  if (!(product > kLeastSignal * std::sqrt(square))) return std::nullopt;
  return product / square;
}

// From the exposure that shows white on, exposure by exposure along shared levels.
Levels StartOf(const Table& table, const std::string& panel) {
  std::vector<std::optional<double>> known(table.codes.size() - 1);
  known.emplace_back(1.0);
  Levels start{
      VectorXd::Zero(static_cast<Index>(known.size())), VectorXd::Zero(table.num_exposures), {}};
  std::vector<bool> done(ToSize(table.num_exposures), false);
  for (int round = 0; round < table.num_exposures; ++round) {
    for (int e = 0; e < table.num_exposures; ++e) {
      if (done[ToSize(e)]) continue;
      const std::optional<double> gain = GainOf(table, e, known);
      if (!gain) continue;
      done[ToSize(e)] = true;
      start.gain(e) = *gain;
      for (std::size_t i = 0; i < table.readings.size(); ++i) {
        const FlatReading& reading = table.readings[i];
        auto& level = known[table.level_of[i]];
        if (reading.exposure == e && !level) level = reading.light / *gain;
      }
    }
  }
  for (std::size_t i = 0; i < table.readings.size(); ++i) {
    if (done[ToSize(table.readings[i].exposure)]) continue;
    throw InputError(panel,
                     fmt::format("exposure {} shares no level with the others that is "
                                 "neither overexposed nor lost in noise",
                                 table.readings[i].exposure + 1),
                     "take exposures nearer to each other");
  }
  for (std::size_t l = 0; l < known.size(); ++l) start.light(static_cast<Index>(l)) = *known[l];
  return start;
}

// Levels and gains together, white held: y = gain light.
Levels FitLevels(const Table& table, const std::string& panel) {
  Levels fit = StartOf(table, panel);
  const Index num_levels = fit.light.size() - 1, size = num_levels + fit.gain.size();
  MatrixXd information;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    information = 1e-300 * MatrixXd::Identity(size, size);
    VectorXd right = VectorXd::Zero(size);
    for (std::size_t i = 0; i < table.readings.size(); ++i) {
      const FlatReading& reading = table.readings[i];
      const auto level = static_cast<Index>(table.level_of[i]);
      VectorXd row = VectorXd::Zero(size);
      if (level < num_levels) row(level) = fit.gain(reading.exposure);
      row(num_levels + reading.exposure) = fit.light(level);
      const double residual = reading.light - fit.gain(reading.exposure) * fit.light(level);
      information += WeightOf(reading) * row * row.transpose();
      right += WeightOf(reading) * residual * row;
    }
    // An exposure without readings has an empty row.
    for (Index i = 0; i < size; ++i) {
      if (information(i, i) < 1e-299) information(i, i) = 1;
    }
    const VectorXd step = information.ldlt().solve(right);
    fit.light.head(num_levels) += step.head(num_levels);
    fit.gain += step.tail(fit.gain.size());
  }
  const MatrixXd covariance = information.ldlt().solve(MatrixXd::Identity(size, size));
  fit.variance = VectorXd::Zero(fit.light.size());
  fit.variance.head(num_levels) = covariance.diagonal().head(num_levels);
  return fit;
}

double GammaLight(double black, double gamma, double code) {
  return black + (1 - black) * std::pow(code, gamma);
}

struct GammaFit {
  double black = 0, gamma = 2.2, black_sd = 0, gamma_sd = 0;
};

// black, gamma and the gains together.
GammaFit FitGamma(const Table& table, const Levels& start) {
  GammaFit fit{std::max(0.0, start.light(0)), 2.2, 0, 0};
  const std::size_t middle = table.codes.size() / 2;
  const double half = start.light(static_cast<Index>(middle));
  if (half > 0 && half < 1) fit.gamma = std::log(half) / std::log(table.codes[middle]);
  VectorXd gain = start.gain;
  const Index size = 2 + gain.size();
  MatrixXd information;
  double chi2 = 0;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    information = 1e-300 * MatrixXd::Identity(size, size);
    VectorXd right = VectorXd::Zero(size);
    chi2 = 0;
    for (const FlatReading& reading : table.readings) {
      const double g = gain(reading.exposure), power = std::pow(reading.code, fit.gamma);
      const double light = GammaLight(fit.black, fit.gamma, reading.code);
      VectorXd row = VectorXd::Zero(size);
      row(0) = g * (1 - power);
      row(1) = reading.code > 0 ? g * (1 - fit.black) * power * std::log(reading.code) : 0;
      row(2 + reading.exposure) = light;
      const double residual = reading.light - g * light, weight = WeightOf(reading);
      information += weight * row * row.transpose();
      right += weight * residual * row;
      chi2 += weight * residual * residual;
    }
    for (Index i = 0; i < size; ++i) {
      if (information(i, i) < 1e-299) information(i, i) = 1;
    }
    const VectorXd step = information.ldlt().solve(right);
    fit.black = std::clamp(fit.black + step(0), 0.0, 0.9);
    fit.gamma = std::clamp(fit.gamma + step(1), 0.1, 10.0);
    gain += step.tail(gain.size());
  }
  const MatrixXd covariance = information.ldlt().solve(MatrixXd::Identity(size, size));
  const auto used = static_cast<double>((gain.array() > 0).count());
  const double freedom = static_cast<double>(table.readings.size()) - 2 - used;
  const double scale = std::sqrt(std::max(1.0, chi2 / std::max(1.0, freedom)));
  fit.black_sd = scale * std::sqrt(covariance(0, 0));
  fit.gamma_sd = scale * std::sqrt(covariance(1, 1));
  return fit;
}

// Pools neighbours that fall until none do (Ayer et al. 1955).
void MakeRising(VectorXd& values) {
  std::vector<std::pair<double, int>> blocks;  // sum, count
  for (const double value : values) {
    blocks.emplace_back(value, 1);
    while (blocks.size() > 1) {
      const auto [last, count] = blocks.back();
      auto& [sum, before] = blocks[blocks.size() - 2];
      if (sum / before <= last / count) break;
      sum += last;
      before += count;
      blocks.pop_back();
    }
  }
  Index i = 0;
  for (const auto& [sum, count] : blocks) {
    for (int k = 0; k < count; ++k) values(i++) = sum / count;
  }
}

// At an end, of the parabola through three points, as far as the cubic stays monotone: from the
// widths and secants of the two intervals there, the outer one first.
double EndSlope(double outer, double inner, double outer_secant, double inner_secant) {
  const double slope =
      ((2 * outer + inner) * outer_secant - outer * inner_secant) / (outer + inner);
  return std::clamp(slope, 0.0, 3 * outer_secant);
}

// Slopes of the monotone cubic through points (Fritsch and Butland 1984).
VectorXd MonotoneSlopes(const std::vector<double>& x, const VectorXd& y) {
  const Index n = y.size();
  VectorXd slopes = VectorXd::Zero(n);
  const auto secant = [&](Index i) {
    return (y(i + 1) - y(i)) /
           (x[static_cast<std::size_t>(i + 1)] - x[static_cast<std::size_t>(i)]);
  };
  for (Index i = 1; i + 1 < n; ++i) {
    const double before = secant(i - 1), after = secant(i);
    if (before * after <= 0) continue;
    const double left = x[static_cast<std::size_t>(i)] - x[static_cast<std::size_t>(i - 1)];
    const double right = x[static_cast<std::size_t>(i + 1)] - x[static_cast<std::size_t>(i)];
    const double a = left + 2 * right, b = 2 * left + right;
    slopes(i) = (a + b) / (b / before + a / after);
  }
  slopes(0) = EndSlope(x[1] - x[0], x[2] - x[1], secant(0), secant(1));
  const std::size_t end = x.size() - 1;
  slopes(n - 1) =
      EndSlope(x[end] - x[end - 1], x[end - 1] - x[end - 2], secant(n - 2), secant(n - 3));
  return slopes;
}

double CubicAt(const std::vector<double>& x, const VectorXd& y, const VectorXd& slopes, double at) {
  const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, at);
  const auto i = static_cast<Index>(above - x.begin()) - 1;
  const double low = x[static_cast<std::size_t>(i)], width = *above - low, t = (at - low) / width;
  const double u = 1 - t;
  return y(i) * u * u * (1 + 2 * t) + y(i + 1) * t * t * (1 + 2 * u) +
         width * t * u * (u * slopes(i) - t * slopes(i + 1));
}

// Through the levels' light, interpolated as its 1/gamma-th power, which is nearly a line.
ToneCurve TableOf(const Table& table, const Levels& levels, double gamma) {
  const double black = levels.light(0);
  VectorXd encoded = (levels.light.array() - black) / (1 - black);
  encoded = encoded.array().max(0.0).min(1.0).pow(1 / gamma);
  MakeRising(encoded);
  const VectorXd slopes = MonotoneSlopes(table.codes, encoded);
  ToneCurve curve;
  curve.kind = ToneCurve::Kind::kTable;
  for (int k = 0; k < kNumKnots; ++k) {
    const double at = static_cast<double>(k) / (kNumKnots - 1);
    const double value = std::clamp(CubicAt(table.codes, encoded, slopes, at), 0.0, 1.0);
    curve.table.push_back(std::pow(value, gamma));
  }
  curve.table.front() = 0;
  curve.table.back() = 1;
  // Rounding may let a flat part fall by a bit.
  for (std::size_t k = 1; k < curve.table.size(); ++k) {
    curve.table[k] = std::max(curve.table[k], curve.table[k - 1]);
  }
  return curve;
}

}  // namespace

ResponseFit FitResponse(const std::vector<FlatReading>& readings, const std::string& panel) {
  const Table table = Sorted(readings, panel);
  const Levels levels = FitLevels(table, panel);
  const GammaFit gamma = FitGamma(table, levels);
  ResponseFit fit;
  fit.gamma = gamma.gamma;
  fit.gamma_sd = gamma.gamma_sd;
  fit.levels = table.codes;
  fit.light.assign(levels.light.begin(), levels.light.end());
  fit.white_light.assign(levels.gain.begin(), levels.gain.end());
  for (std::size_t l = 0; l < table.codes.size(); ++l) {
    const double expected = GammaLight(gamma.black, gamma.gamma, table.codes[l]);
    fit.gamma_residual = std::max(fit.gamma_residual, std::abs(fit.light[l] - expected));
  }
  if (fit.gamma_residual > kMostGammaResidual) {
    fit.curve = TableOf(table, levels, gamma.gamma);
    fit.black = std::clamp(levels.light(0), 0.0, 0.9);
    fit.black_sd = std::sqrt(levels.variance(0));
  } else {
    fit.curve = {ToneCurve::Kind::kGamma, gamma.gamma, {}};
    fit.black = gamma.black;
    fit.black_sd = gamma.black_sd;
  }
  return fit;
}

}  // namespace lamella
