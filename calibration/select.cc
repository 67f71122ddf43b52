#include "calibration/select.h"

#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

namespace lamella {
namespace {

constexpr double kKnown = 100;        // smallest eigenvalue asked for
constexpr double kBenefitPx = 0.01;   // below it the ray map does not care
constexpr double kHeldOutErrors = 2;  // standard errors

struct Candidate {
  const char* name;
  bool FreeGroups::*group;
};
constexpr Candidate kCandidates[] = {{"plate thickness", &FreeGroups::plate},
                                     {"bow", &FreeGroups::bow},
                                     {"scale", &FreeGroups::scale},
                                     {"aspect and skew", &FreeGroups::aspect_skew},
                                     {"k3", &FreeGroups::k3},
                                     {"index", &FreeGroups::index}};

bool HeldOut(int view) { return view % 4 == 1; }

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

// Squared residuals of the points of the views left out, when all but these views' own poses and
// slips is known from the others.
std::vector<double> HeldOutSquares(const Fit& fit, const Structure& structure,
                                   const Observations& observations) {
  const Weighting others = OfViews(fit, structure, [](int view) { return !HeldOut(view); });
  const Weighting left_out = OfViews(fit, structure, HeldOut);
  const Minimum known =
      Minimise(fit.state, structure, fit.columns, observations, others, {20, 1e-8, 1e-4, {}});
  MinimiseOptions poses_only{20, 1e-8, 1e-4, {}};
  poses_only.fixed.assign(static_cast<std::size_t>(fit.columns.size), 0);
  for (int i = 0; i < fit.columns.num_display; ++i) {
    poses_only.fixed[static_cast<std::size_t>(i)] = 1;
  }
  const Minimum posed =
      Minimise(known.state, structure, fit.columns, observations, left_out, poses_only);
  std::vector<double> squares;
  const auto residuals = WhitenedResiduals(posed.state, structure, observations);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
      if (left_out.inlier[i][static_cast<std::size_t>(k)]) {
        squares.push_back(residuals[i].col(k).squaredNorm());
      }
    }
  }
  return squares;
}

// By how many standard errors the mean square falls.
double GainInErrors(const std::vector<double>& before, const std::vector<double>& after) {
  double sum = 0, squares = 0;
  const auto num = static_cast<double>(before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double gain = before[i] - after[i];
    sum += gain;
    squares += gain * gain;
  }
  const double mean = sum / num, variance = squares / num - mean * mean;
  return num > 1 && variance > 0 ? mean / std::sqrt(variance / num) : 0;
}

// Tests a group from the cheapest question to the dearest; stops at the first no.
GroupVerdict Judge(const Candidate& candidate, const Fit& fit, const Fit& larger,
                   const Structure& structure, const Observations& observations,
                   const EyeBox& box) {
  GroupVerdict verdict;
  verdict.group = candidate.name;
  const int added = larger.columns.num_display - fit.columns.num_display;
  verdict.chi2_fall = (fit.equations.cost - larger.equations.cost) / larger.variance;
  verdict.chi2_needed = added * std::log(std::max(2, fit.num_residuals));
  if (!(verdict.chi2_fall > verdict.chi2_needed)) {
    verdict.reason = fmt::format(
        "the photographs do not ask for it: chi^2 falls by {:.1f}, {:.1f} "
        "is what chance may do",
        verdict.chi2_fall, verdict.chi2_needed);
    return verdict;
  }
  const Degeneracy degeneracy = DegeneracyOf(larger);
  verdict.degeneracy = degeneracy.smallest;
  if (!(degeneracy.smallest >= kKnown)) {
    verdict.reason = fmt::format("the photographs do not carry it: with it free, {} is unknown",
                                 NameOfDirection(degeneracy, larger.columns));
    return verdict;
  }
  const std::vector<ProbedRay> rays = RaysToProbe(structure, box);
  const auto map = [&](const Fit& of) {
    return PixelsOfRays(CalibrationOf(of.state, structure), structure.reference, rays);
  };
  verdict.benefit_px = CompareRays(map(fit), map(larger)).rms_px;
  if (!(verdict.benefit_px > kBenefitPx)) {
    verdict.reason = fmt::format("it changes rays by {:.4f} px only", verdict.benefit_px);
    return verdict;
  }
  verdict.heldout_gain = GainInErrors(HeldOutSquares(fit, structure, observations),
                                      HeldOutSquares(larger, structure, observations));
  if (!(verdict.heldout_gain > kHeldOutErrors)) {
    verdict.reason = "views left out are not predicted better with it";
    return verdict;
  }
  verdict.freed = true;
  verdict.reason = fmt::format("chi^2 falls by {:.0f}, rays change by {:.3f} px", verdict.chi2_fall,
                               verdict.benefit_px);
  return verdict;
}

}  // namespace

Selection SelectGroups(Fit base, const Structure& structure, const Observations& observations,
                       const EyeBox& box) {
  Selection selection{std::move(base), {}};
  for (const Candidate& candidate : kCandidates) {
    Fit& fit = selection.fit;
    FreeGroups free = fit.free;
    free.*candidate.group = true;
    if (ColumnsOf(structure, free, observations).size == fit.columns.size) continue;
    Fit larger = Refit(fit, structure, observations, free);
    selection.verdicts.push_back(Judge(candidate, fit, larger, structure, observations, box));
    if (!selection.verdicts.back().freed) continue;
    Settle(structure, observations, larger);
    fit = std::move(larger);
  }
  return selection;
}

}  // namespace lamella
