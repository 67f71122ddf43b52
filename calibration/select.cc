#include "calibration/select.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "calibration/held_out.h"

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

// The columns of a group's parameters.
std::vector<int> ColumnsOfGroup(const Columns& columns, bool FreeGroups::*group) {
  std::vector<int> of;
  const auto add = [&](int column) {
    if (column >= 0) of.push_back(column);
  };
  if (group == &FreeGroups::k3 && columns.k3) {
    for (const int camera : columns.camera) add(camera + 8);
  }
  for (const auto* shapes : {&columns.emitter_shape, &columns.modulator_shape}) {
    for (const std::array<int, 4>& shape : *shapes) {
      if (group == &FreeGroups::scale) add(shape[0]);
      if (group == &FreeGroups::aspect_skew) add(shape[1]);
      if (group == &FreeGroups::aspect_skew) add(shape[2]);
      if (group == &FreeGroups::bow) add(shape[3]);
    }
  }
  if (group == &FreeGroups::index) std::for_each(columns.index.begin(), columns.index.end(), add);
  if (group == &FreeGroups::plate) std::for_each(columns.plate.begin(), columns.plate.end(), add);
  return of;
}

// What freeing groups would do to a fit's chi^2, were residuals linear in all parameters (Rao's
// score test, 1948): one linearisation with all of them free, no new solution for each.
class Scores {
 public:
  Scores(const Fit& fit, const Structure& structure, const Observations& observations) : fit_(fit) {
    FreeGroups all = fit.free;
    for (const Candidate& candidate : kCandidates) all.*candidate.group = true;
    columns_ = ColumnsOf(structure, all, observations);
    const NormalEquations equations =
        Linearise(fit.state, structure, columns_, observations, fit.weighting);
    scale_ = equations.hessian.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    hessian_ = scale_.asDiagonal() * equations.hessian * scale_.asDiagonal();
    gradient_ = scale_.asDiagonal() * equations.gradient;
    std::vector<char> tried(static_cast<std::size_t>(columns_.size), 0);
    for (const Candidate& candidate : kCandidates) {
      if (fit.free.*candidate.group) continue;
      for (const int column : ColumnsOfGroup(columns_, candidate.group)) {
        tried[static_cast<std::size_t>(column)] = 1;
      }
    }
    for (int i = 0; i < columns_.size; ++i) {
      if (tried[static_cast<std::size_t>(i)] == 0) base_.push_back(i);
    }
    base_hessian_.compute(hessian_(base_, base_));
  }

  // In units of the larger model's variance; no number where the group is not determined.
  double FallOf(bool FreeGroups::*group) const {
    const std::vector<int> own = ColumnsOfGroup(columns_, group);
    if (own.empty()) return 0;
    const Eigen::MatrixXd gain = base_hessian_.solve(hessian_(base_, own)).transpose();
    const Eigen::MatrixXd left = hessian_(own, own) - gain * hessian_(base_, own);
    const Eigen::VectorXd slope = gradient_(own) - gain * gradient_(base_);
    const double fall = slope.dot(left.ldlt().solve(slope));
    const double chi2 = fit_.equations.cost;
    return fall / (fit_.variance * std::max(1e-12, (chi2 - fall) / chi2));
  }

 private:
  const Fit& fit_;
  Columns columns_;
  std::vector<int> base_;
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd gradient_, scale_;
  Eigen::LDLT<Eigen::MatrixXd> base_hessian_;
};

// Groups that are held, what lowers chi^2 most first: it takes the place of what else would seem to
// be asked for. Equal ones in their order.
std::vector<Candidate> ByScore(const Scores& scores, const FreeGroups& free) {
  std::vector<std::pair<double, Candidate>> falls;
  for (const Candidate& candidate : kCandidates) {
    if (free.*candidate.group) continue;
    const double fall = scores.FallOf(candidate.group);
    falls.emplace_back(std::isfinite(fall) ? fall : 0, candidate);
  }
  std::stable_sort(falls.begin(), falls.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Candidate> order;
  for (const auto& [fall, candidate] : falls) order.push_back(candidate);
  return order;
}

std::string NotAskedFor(const GroupVerdict& verdict) {
  return fmt::format(
      "the photographs do not ask for it: chi^2 falls by {:.1f}, {:.1f} is what chance may do",
      verdict.chi2_fall, verdict.chi2_needed);
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
    verdict.reason = NotAskedFor(verdict);
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

// The fit with a group's parameters at the design's values.
Fit WithGroupAsDesigned(const Fit& fit, bool FreeGroups::*group, const Structure& structure) {
  Fit next = fit;
  const auto reset = [&](Eigen::Vector4d& shape, const PanelCalibration& design) {
    if (group == &FreeGroups::scale) shape(0) = design.scale;
    if (group == &FreeGroups::aspect_skew) shape.segment<2>(1) << design.aspect, design.skew;
    if (group == &FreeGroups::bow) shape(3) = design.bow_mm;
  };
  for (std::size_t i = 0; i < next.state.layers.size(); ++i) {
    LayerState& layer = next.state.layers[i];
    const LayerCalibration& design = structure.design.layers[i];
    reset(layer.emitter_shape, design.emitter);
    if (design.modulator) reset(layer.modulator_shape, *design.modulator);
    if (group == &FreeGroups::index) layer.index = design.index;
    if (group == &FreeGroups::plate && design.plate) layer.plate_mm = design.plate->thickness_mm;
  }
  if (group != &FreeGroups::k3) return next;
  for (LensParameters& camera : next.state.cameras) camera(8) = 0;
  return next;
}

// Takes a group's column back where, beside those freed after it, chi^2 no longer asks for it.
void TakeBack(const Candidate& candidate, const Structure& structure,
              const Observations& observations, Selection& selection) {
  Fit& fit = selection.fit;
  if (!(fit.free.*candidate.group)) return;
  FreeGroups free = fit.free;
  free.*candidate.group = false;
  Fit smaller =
      Refit(WithGroupAsDesigned(fit, candidate.group, structure), structure, observations, free);
  const int removed = fit.columns.num_display - smaller.columns.num_display;
  const double rise = (smaller.equations.cost - fit.equations.cost) / fit.variance;
  if (removed == 0 || rise > removed * std::log(std::max(2, fit.num_residuals))) return;
  for (GroupVerdict& verdict : selection.verdicts) {
    if (verdict.group != candidate.name) continue;
    verdict.freed = false;
    verdict.reason =
        fmt::format("not needed beside the others: chi^2 rises by {:.1f} without", rise);
  }
  fit = std::move(smaller);
}

// Nothing in a gap refracts less than air: what an index below 1 was fitted to is air, by chance or
// by what else is not modelled. Whether there was any.
bool HoldAir(const Structure& structure, const Observations& observations, Fit& fit) {
  FreeGroups free = fit.free;
  Fit next = fit;
  for (std::size_t i = 0; i < next.state.layers.size(); ++i) {
    double& index = next.state.layers[i].index;
    if (fit.columns.index[i] < 0 || index >= 1) continue;
    index = 1;
    free.air.push_back(static_cast<int>(i));
  }
  if (free == fit.free) return false;
  fit = Refit(next, structure, observations, free);
  return true;
}

void Record(GroupVerdict verdict, std::vector<GroupVerdict>& verdicts) {
  for (GroupVerdict& other : verdicts) {
    if (other.group != verdict.group) continue;
    other = std::move(verdict);
    return;
  }
  verdicts.push_back(std::move(verdict));
}

// Frees the group where the photographs ask for it and carry it; whether they do.
bool Try(const Candidate& candidate, const Structure& structure, const Observations& observations,
         const EyeBox& box, std::optional<Scores>& scores, Selection& selection) {
  Fit& fit = selection.fit;
  FreeGroups free = fit.free;
  if (free.*candidate.group) return false;
  free.*candidate.group = true;
  const int added = ColumnsOf(structure, free, observations).size - fit.columns.size;
  if (added == 0) return false;
  if (!scores) scores.emplace(fit, structure, observations);
  GroupVerdict verdict;
  verdict.group = candidate.name;
  verdict.chi2_fall = scores->FallOf(candidate.group);
  verdict.chi2_needed = added * std::log(std::max(2, fit.num_residuals));
  if (verdict.chi2_fall <= verdict.chi2_needed) {
    verdict.reason = NotAskedFor(verdict);
    Record(std::move(verdict), selection.verdicts);
    return false;
  }
  Fit larger = Refit(fit, structure, observations, free);
  verdict = Judge(candidate, fit, larger, structure, observations, box);
  const bool freed = verdict.freed;
  Record(std::move(verdict), selection.verdicts);
  if (!freed) return false;
  scores.reset();  // they are the smaller model's
  fit = std::move(larger);
  return true;
}

}  // namespace

Selection SelectGroups(const CalibrationState& start, const Structure& structure,
                       const Observations& observations, const EyeBox& box) {
  // Which points count and how far photographs slip is found with shapes free, so that what a base
  // model can't explain is not taken for errors of the photographs.
  FreeGroups wide;
  wide.plate = wide.bow = wide.scale = wide.aspect_skew = true;
  Selection selection{Solve(start, structure, observations, wide), {}};
  Fit& fit = selection.fit;
  for (const Candidate& candidate : kCandidates) {
    fit = WithGroupAsDesigned(fit, candidate.group, structure);
  }
  fit = Refit(fit, structure, observations, {});
  bool again = true;
  for (int pass = 0; again && pass < 3; ++pass) {
    again = false;
    std::optional<Scores> scores(std::in_place, fit, structure, observations);
    for (const Candidate& candidate : ByScore(*scores, fit.free)) {
      if (Try(candidate, structure, observations, box, scores, selection)) again = true;
    }
  }
  for (const Candidate& candidate : kCandidates) {
    TakeBack(candidate, structure, observations, selection);
  }
  do {
    Settle(structure, observations, fit);
  } while (HoldAir(structure, observations, fit));
  return selection;
}

}  // namespace lamella
