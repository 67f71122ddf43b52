#include "calibration/camera_response.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
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

constexpr int kKnots = 16;
constexpr double kLeastNumber = 0.02, kMostNumber = 0.97;  // of 8 bits: code 5, and no clipping
constexpr double kLogError = 0.005;                        // of a reading's light, beside its noise
constexpr double kBend = 0.03;  // standard deviation of a knot's second difference
// Noise of less than a code does not average rounding away.
constexpr double kCodeRounding = 1.0 / 255 / 3.5;
constexpr std::size_t kLeastPatches = 12;
constexpr double kMostRms = 0.1;

struct Place {
  Index knot;
  double share;  // of the next knot
};

Place PlaceOf(const std::vector<double>& knots, double log_number) {
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, log_number);
  const auto i = static_cast<std::size_t>(above - knots.begin()) - 1;
  return {static_cast<Index>(i), (log_number - knots[i]) / (knots[i + 1] - knots[i])};
}

// Those of patches that two exposures show well.
std::vector<NumberReading> Unclipped(const std::vector<NumberReading>& readings,
                                     const std::string& where) {
  std::map<int, std::set<double>> exposures;
  const auto is_good = [](const NumberReading& reading) {
    return reading.number >= kLeastNumber && reading.number <= kMostNumber;
  };
  for (const NumberReading& reading : readings) {
    if (is_good(reading)) exposures[reading.patch].insert(reading.exposure);
  }
  std::erase_if(exposures, [](const auto& entry) { return entry.second.size() < 2; });
  if (exposures.size() < kLeastPatches) {
    throw InputError(where,
                     fmt::format("{} levels are seen at two exposures or more, too few to tell the "
                                 "camera's tone curve",
                                 exposures.size()),
                     "give linear 16-bit photographs, or white at about 80 % of full scale");
  }
  std::vector<NumberReading> usable;
  std::copy_if(readings.begin(), readings.end(), std::back_inserter(usable),
               [&](const NumberReading& r) { return is_good(r) && exposures.contains(r.patch); });
  return usable;
}

// Unknown: log light at the knots, then log light of every patch at exposure 1.
struct Problem {
  std::vector<double> knots;
  std::map<int, Index> column_of;  // of each patch
  MatrixXd information;
  VectorXd right;

  void Add(const std::vector<std::pair<Index, double>>& row, double value, double weight) {
    for (const auto& [i, a] : row) {
      right(i) += weight * a * value;
      for (const auto& [j, b] : row) information(i, j) += weight * a * b;
    }
  }
};

Problem ProblemOf(const std::vector<NumberReading>& readings) {
  Problem problem;
  double least = 1;
  for (const NumberReading& reading : readings) {
    least = std::min(least, reading.number);
    problem.column_of.emplace(reading.patch, 0);
  }
  for (int k = 0; k < kKnots; ++k) {
    problem.knots.push_back(std::log(least) * (1 - static_cast<double>(k) / (kKnots - 1)));
  }
  Index column = kKnots;
  for (auto& [patch, at] : problem.column_of) at = column++;
  problem.information = MatrixXd::Zero(column, column);
  problem.right = VectorXd::Zero(column);
  for (const NumberReading& reading : readings) {
    const Place place = PlaceOf(problem.knots, std::log(reading.number));
    // A number's noise as its light's: the curves' slopes are about 2.
    const double relative =
        4 * (reading.variance + kCodeRounding * kCodeRounding) / (reading.number * reading.number);
    problem.Add({{place.knot, 1 - place.share},
                 {place.knot + 1, place.share},
                 {problem.column_of.at(reading.patch), -1}},
                std::log(reading.exposure), 1 / (relative + kLogError * kLogError));
  }
  for (Index k = 1; k + 1 < kKnots; ++k) {
    problem.Add({{k - 1, 1}, {k, -2}, {k + 1, 1}}, 0, 1 / (kBend * kBend));
  }
  problem.Add({{kKnots - 1, 1}}, 0, 1e12);  // full scale is 1
  return problem;
}

}  // namespace

double CameraResponse::LightOf(double number) const {
  if (!(number > 0)) return 0;
  const Place place = PlaceOf(log_number, std::log(number));
  const auto i = static_cast<std::size_t>(place.knot);
  return std::exp((1 - place.share) * log_light[i] + place.share * log_light[i + 1]);
}

CameraResponse EstimateCameraResponse(const std::vector<NumberReading>& readings,
                                      const std::string& where) {
  const std::vector<NumberReading> usable = Unclipped(readings, where);
  const Problem problem = ProblemOf(usable);
  const VectorXd solution = problem.information.ldlt().solve(problem.right);
  CameraResponse response{problem.knots, {solution.data(), solution.data() + kKnots}, 0};
  for (std::size_t k = 1; k < response.log_light.size(); ++k) {
    if (response.log_light[k] > response.log_light[k - 1]) continue;
    throw InputError(where, "the tone curve that its exposures imply does not rise",
                     "give linear 16-bit photographs, taken with all corrections off");
  }
  double squares = 0;
  for (const NumberReading& reading : usable) {
    const double patch = solution(problem.column_of.at(reading.patch));
    const double residual =
        std::log(response.LightOf(reading.number)) - patch - std::log(reading.exposure);
    squares += residual * residual;
  }
  response.rms = std::sqrt(squares / static_cast<double>(usable.size()));
  if (response.rms <= kMostRms) return response;
  throw InputError(
      where,
      fmt::format("no tone curve fits its exposures: they differ by {:.0f} %", 100 * response.rms),
      "give linear 16-bit photographs, taken with all corrections off");
}

}  // namespace lamella
