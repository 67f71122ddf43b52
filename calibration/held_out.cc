#include "calibration/held_out.h"

#include <cmath>
#include <functional>

#include "calibration/minimise.h"

namespace lamella {
namespace {

constexpr int kFolds = 4;

// The points of some views only.
Weighting OfViews(const Fit& fit, const Structure& structure,
                  const std::function<bool(int)>& wanted) {
  Weighting weighting = fit.weighting;
  for (std::size_t i = 0; i < weighting.inlier.size(); ++i) {
    std::vector<char>& inlier = weighting.inlier[i];
    if (!wanted(structure.view_of_photo[i])) inlier.assign(inlier.size(), 0);
  }
  return weighting;
}

// Those of every fourth view.
void AddFold(const Fit& fit, const Structure& structure, const Observations& observations, int fold,
             std::vector<double>& squares) {
  const auto held_out = [fold](int view) { return view % kFolds == fold; };
  const Weighting others = OfViews(fit, structure, [&](int view) { return !held_out(view); });
  const Weighting left_out = OfViews(fit, structure, held_out);
  MinimiseOptions nearby{20, 1e-8, 1e-2};
  const Minimum known = Minimise(fit.state, structure, fit.columns, observations, others, nearby);
  nearby.hold_display = true;
  const Minimum posed =
      Minimise(known.state, structure, fit.columns, observations, left_out, nearby);
  const auto residuals = WhitenedResiduals(posed.state, structure, observations);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
      if (left_out.inlier[i][static_cast<std::size_t>(k)]) {
        squares.push_back(residuals[i].col(k).squaredNorm());
      }
    }
  }
}

}  // namespace

std::vector<double> HeldOutSquares(const Fit& fit, const Structure& structure,
                                   const Observations& observations) {
  std::vector<double> squares;
  for (int fold = 0; fold < kFolds; ++fold) {
    AddFold(fit, structure, observations, fold, squares);
  }
  return squares;
}

double GainInErrors(const std::vector<double>& before, const std::vector<double>& after) {
  const auto num = static_cast<double>(before.size());
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < before.size(); ++i) mean += (before[i] - after[i]) / num;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double off = before[i] - after[i] - mean;
    squares += off * off;
  }
  return squares > 0 ? mean / std::sqrt(squares / num / num) : 0;
}

}  // namespace lamella
