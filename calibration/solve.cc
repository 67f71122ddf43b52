#include "calibration/solve.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "calibration/inliers.h"
#include "calibration/minimise.h"
#include "calibration/slip.h"

namespace lamella {
namespace {

using Residuals = std::vector<Eigen::Matrix2Xd>;

constexpr double kLooseSlipPx = 0.3;
constexpr std::size_t kEnough = 64;  // points of a photograph to find the way

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
    const double deviation = RobustDeviation(WhitenedResiduals(state, structure, observations));
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

// Panels are about equally sharp: all photographs are of one kind.
std::vector<PhotoKind> KindsOf(const Observations& observations) {
  std::vector<PhotoKind> kinds;
  for (const PanelPhoto& photo : observations.photos) {
    kinds.push_back({fmt::format("{} ({})", photo.photo, NameOf(photo.panel)), 0});
  }
  return kinds;
}

void Trim(const Observations& observations, const Residuals& residuals, Fit& fit) {
  const bool slips = !fit.columns.slip.empty();
  TrimmedPoints trimmed =
      TrimPoints(residuals, slips ? fit.state.slips_px : std::vector<Eigen::Vector2d>{},
                 KindsOf(observations));
  fit.weighting.inlier = std::move(trimmed.inlier);
  fit.rejected = std::move(trimmed.rejected);
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
  fit.weighting.cauchy = 2 * RobustDeviation(WhitenedResiduals(fit.state, structure, observations));
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
    if (fit.free.slip) {
      fit.weighting.slip_sd_px =
          EstimateSlip({fit.equations, fit.columns.slip, fit.columns.first_slip, fit.state.slips_px,
                        fit.weighting.slip_sd_px, fit.variance});
    }
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
