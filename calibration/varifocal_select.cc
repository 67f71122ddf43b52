#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calibration/held_out.h"
#include "calibration/varifocal_rays.h"
#include "calibration/varifocal_solve.h"

namespace lamella {
namespace {

constexpr double kBendKnown = 100, kBendBenefitPx = 0.01, kBendHeldOutErrors = 2;

struct BendCandidate {
  const char* name;
  bool VarifocalGroups::*group;
};
constexpr std::array kBends = {BendCandidate{"pincushion", &VarifocalGroups::pincushion},
                               BendCandidate{"bow", &VarifocalGroups::bow}};

GroupVerdict Compare(const BendCandidate& candidate, const VarifocalFit& fit,
                     const VarifocalFit& larger, const VarifocalTask& task, const EyeBox& box) {
  GroupVerdict verdict;
  verdict.group = candidate.name;
  const int added = larger.columns.common.num_display - fit.columns.common.num_display;
  verdict.chi2_fall = (fit.equations.cost - larger.equations.cost) / larger.variance;
  verdict.chi2_needed = added * std::log(std::max(2, fit.num_residuals));
  if (!(verdict.chi2_fall > verdict.chi2_needed)) {
    verdict.reason = fmt::format("chi^2 would fall by {:.1f}, {:.1f} are asked for",
                                 verdict.chi2_fall, verdict.chi2_needed);
    return verdict;
  }
  const Degeneracy degeneracy = DegeneracyOf(larger);
  verdict.degeneracy = degeneracy.smallest;
  if (!(degeneracy.smallest >= kBendKnown)) {
    verdict.reason = fmt::format("the photographs do not carry it: with it free, {} is unknown",
                                 NameOfDirection(degeneracy, larger.columns.common));
    return verdict;
  }
  verdict.benefit_px = ChangeOfRays(fit.state, larger.state, task, box);
  if (!(verdict.benefit_px > kBendBenefitPx)) {
    verdict.reason = fmt::format("it changes rays by {:.4f} px only", verdict.benefit_px);
    return verdict;
  }
  verdict.heldout_gain = GainInErrors(HeldOutSquares(fit, task), HeldOutSquares(larger, task));
  if (!(verdict.heldout_gain > kBendHeldOutErrors)) {
    verdict.reason = "views left out are not predicted better with it";
    return verdict;
  }
  verdict.freed = true;
  verdict.reason = fmt::format("chi^2 falls by {:.0f}, rays change by {:.3f} px", verdict.chi2_fall,
                               verdict.benefit_px);
  return verdict;
}

// Frees the group that lowers chi^2 most, if it passes; whether one was freed.
bool FreeBest(const VarifocalTask& task, const EyeBox& box, VarifocalSelection& selection) {
  std::vector<std::pair<const BendCandidate*, VarifocalFit>> larger;
  for (const BendCandidate& candidate : kBends) {
    VarifocalGroups free = selection.fit.free;
    if (std::exchange(free.*candidate.group, true)) continue;
    larger.emplace_back(&candidate, Refit(selection.fit, task, free));
  }
  std::stable_sort(larger.begin(), larger.end(), [](const auto& a, const auto& b) {
    return a.second.equations.cost < b.second.equations.cost;
  });
  for (auto& [candidate, fit] : larger) {
    GroupVerdict verdict = Compare(*candidate, selection.fit, fit, task, box);
    std::erase_if(selection.verdicts,
                  [&](const GroupVerdict& other) { return other.group == verdict.group; });
    selection.verdicts.push_back(verdict);
    if (!verdict.freed) continue;
    selection.fit = std::move(fit);
    return true;
  }
  return false;
}

}  // namespace

VarifocalSelection SelectGroups(const VarifocalState& start, const VarifocalTask& task,
                                const EyeBox& box) {
  VarifocalGroups wide;
  wide.bow = wide.pincushion = true;
  VarifocalSelection selection{Refit(Solve(start, task, wide), task, {}), {}};
  while (FreeBest(task, box, selection)) {
  }
  return selection;
}

}  // namespace lamella
