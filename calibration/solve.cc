#include "calibration/solve.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "calibration/minimise.h"
#include "calibration/slip.h"

namespace lamella {
namespace {

using Residuals = std::vector<Eigen::Matrix2Xd>;

// The median of |r|^2 of a Gaussian of deviation s in the plane is 2 ln 2 s^2.
constexpr double kMedianOfSquares = 1.3862943611198906;
constexpr double kLooseSlipPx = 0.3;
constexpr std::size_t kEnough = 64;  // points of a photograph to find the way
constexpr double kTrim = 4;          // deviations; of Gaussian points 3e-4 lie beyond

double MedianSquare(std::vector<double> squares) {
  if (squares.empty()) return 0;
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return *middle;
}

std::vector<double> Squares(const Eigen::Matrix2Xd& residuals) {
  const Eigen::RowVectorXd squares = residuals.colwise().squaredNorm();
  return {squares.begin(), squares.end()};
}

// Robust deviation of whitened residuals: 1 where the stated covariances are right.
double Deviation(const Residuals& residuals) {
  std::vector<double> all;
  for (const Eigen::Matrix2Xd& photo : residuals) {
    const std::vector<double> squares = Squares(photo);
    all.insert(all.end(), squares.begin(), squares.end());
  }
  return std::max(std::sqrt(MedianSquare(all) / kMedianOfSquares), 1e-6);
}

// At most about `most` points of each photograph, evenly chosen: enough to find the way.
Observations Thinned(const Observations& observations, std::size_t most) {
  Observations thinned = observations;
  for (std::size_t i = 0; i < thinned.photos.size(); ++i) {
    const std::vector<Observation>& all = observations.photos[i].points;
    const std::size_t step = std::max<std::size_t>(1, (all.size() + most - 1) / most);
    std::vector<Observation>& some = thinned.photos[i].points;
    some.clear();
    for (std::size_t k = 0; k < all.size(); k += step) some.push_back(all[k]);
  }
  return thinned;
}

// Cauchy's loss from far away: its width follows the residuals down.
CalibrationState Approach(CalibrationState state, const Structure& structure,
                          const Columns& columns, const Observations& observations,
                          Weighting& weighting, int& iterations) {
  double last = 0;
  for (int round = 0; round < 20; ++round) {
    const double deviation = Deviation(WhitenedResiduals(state, structure, observations));
    weighting.cauchy = 2 * deviation;
    const bool settled = round > 0 && deviation > 0.9 * last;
    const Minimum minimum = Minimise(state, structure, columns, observations, weighting,
                                     {settled ? 12 : 2, round == 0 ? 1e-4 : 1e-8, 1e-2});
    iterations += minimum.iterations;
    state = minimum.state;
    if (settled) break;
    last = deviation;
  }
  return state;
}

std::string Label(const PanelPhoto& photo) {
  return fmt::format("{} ({})", photo.photo, NameOf(photo.panel));
}

// Points within 4 deviations of photographs that agree with the rest.
void Trim(const Observations& observations, const Residuals& residuals, Fit& fit) {
  const double deviation = Deviation(residuals);
  fit.rejected.clear();
  fit.weighting.inlier.assign(residuals.size(), {});
  std::vector<double> slips;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (!fit.columns.slip.empty()) slips.push_back(fit.state.slips_px[i].squaredNorm());
  }
  const double slip = std::sqrt(MedianSquare(slips) / kMedianOfSquares);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const std::vector<double> squares = Squares(residuals[i]);
    std::vector<char>& inlier = fit.weighting.inlier[i];
    double inside = 0;
    for (const double square : squares) {
      inlier.push_back(square < kTrim * kTrim * deviation * deviation);
      inside += inlier.back();
    }
    if (squares.empty()) continue;
    const double share = inside / static_cast<double>(squares.size());
    const double own = std::sqrt(MedianSquare(squares) / kMedianOfSquares);
    const bool moved = fit.state.slips_px[i].norm() > 6 * std::max(slip, 0.02);
    std::string why;
    if (share < 0.5) {
      why = fmt::format(
          "{:.0f} % of its points disagree with the other photographs: another "
          "panel's or view's file, or the camera had moved",
          100 * (1 - share));
    } else if (moved) {
      why = fmt::format("shifted by {:.2f} px against its view: the camera had moved",
                        fit.state.slips_px[i].norm());
    } else if (own > 2 * deviation) {
      why = fmt::format("its points scatter {:.1f} times as much as the others': out of focus?",
                        own / deviation);
    } else {
      continue;
    }
    inlier.assign(squares.size(), 0);
    fit.rejected.push_back(Label(observations.photos[i]) + ": " + why);
  }
}

// chi^2 per degree of freedom, of points that count.
void Judge(const Residuals& residuals, Fit& fit) {
  double chi2 = 0;
  fit.num_residuals = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
      if (!fit.weighting.inlier[i][static_cast<std::size_t>(k)]) continue;
      chi2 += residuals[i].col(k).squaredNorm();
      fit.num_residuals += 2;
    }
  }
  for (std::size_t i = 0; i < fit.columns.slip.size(); ++i) {
    chi2 += (fit.state.slips_px[i] / fit.weighting.slip_sd_px).squaredNorm();
  }
  // A slip brings as many residuals (its prior) as columns.
  const int freedom = fit.num_residuals - fit.columns.first_slip;
  fit.variance = freedom > 0 ? chi2 / freedom : 1;
}

// From near the solution; to `smallest_gain` of chi^2.
void LeastSquares(const Structure& structure, const Observations& observations,
                  double smallest_gain, Fit& fit) {
  fit.weighting.cauchy = 0;
  Minimum minimum = Minimise(fit.state, structure, fit.columns, observations, fit.weighting,
                             {40, 1e-8, smallest_gain});
  fit.iterations += minimum.iterations;
  fit.converged = minimum.converged;
  fit.state = std::move(minimum.state);
  fit.equations = Linearise(fit.state, structure, fit.columns, observations, fit.weighting);
  Judge(WhitenedResiduals(fit.state, structure, observations), fit);
}

}  // namespace

Fit Solve(const CalibrationState& start, const Structure& structure,
          const Observations& observations, const FreeGroups& free) {
  Fit fit;
  fit.free = free;
  fit.state = start;
  FreeGroups without_slip = free;
  without_slip.slip = false;
  fit.columns = ColumnsOf(structure, without_slip, observations);
  fit.state = Approach(fit.state, structure, fit.columns, Thinned(observations, kEnough),
                       fit.weighting, fit.iterations);
  fit.columns = ColumnsOf(structure, free, observations);
  Settle(structure, observations, fit);
  return fit;
}

void Settle(const Structure& structure, const Observations& observations, Fit& fit) {
  fit.weighting.inlier.clear();
  fit.weighting.cauchy = 2 * Deviation(WhitenedResiduals(fit.state, structure, observations));
  // Loosely held, so that a photograph that was shifted is not taken for one that disagrees.
  fit.weighting.slip_sd_px = kLooseSlipPx;
  Minimum minimum = Minimise(fit.state, structure, fit.columns, Thinned(observations, kEnough),
                             fit.weighting, {6, 1e-8, 1e-2});
  fit.iterations += minimum.iterations;
  fit.state = std::move(minimum.state);
  for (int round = 0; round < 4; ++round) {
    const auto before = fit.weighting.inlier;
    Trim(observations, WhitenedResiduals(fit.state, structure, observations), fit);
    if (round > 0 && fit.weighting.inlier == before) break;
    LeastSquares(structure, observations, 1e-2, fit);
    if (fit.free.slip) fit.weighting.slip_sd_px = EstimateSlip(fit);
  }
  LeastSquares(structure, observations, 1e-14, fit);
}

Fit Refit(const Fit& fit, const Structure& structure, const Observations& observations,
          const FreeGroups& free) {
  Fit next = fit;
  next.free = free;
  next.columns = ColumnsOf(structure, free, observations);
  next.iterations = 0;
  LeastSquares(structure, observations, 1e-14, next);
  return next;
}

}  // namespace lamella
