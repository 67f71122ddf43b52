#include "calibration/gates.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "calibration/held_out.h"
#include "calibration/residual_map.h"

namespace lamella {
namespace {

constexpr double kLargestSlipPx = 0.05, kLargestCellPx = 0.03;
constexpr double kLeastChi2 = 0.7, kMostChi2 = 1.5, kMostHeldOut = 1.3;
constexpr double kChance = 4;  // standard deviations

void CheckSlip(const Fit& fit, std::vector<Weakness>& failures) {
  if (fit.columns.slip.empty() || fit.weighting.slip_sd_px <= kLargestSlipPx) return;
  failures.push_back(
      {fmt::format("gaps and offsets: photographs of one position are shifted against one another "
                   "by {:.3f} px ({} is the most): the camera does not stand still",
                   fit.weighting.slip_sd_px, kLargestSlipPx),
       "fix the camera, release it from afar, and take all positions again"});
}

// chi^2 of some points, and what it should be.
struct Chi2 {
  double is = 0, expected = 0;
  int num = 0;
  double Relative() const { return expected > 0 ? is / expected : 1; }
  // Standard deviation of the relative one: each point has two residuals.
  double Chance() const { return num > 0 ? 1 / std::sqrt(num) : 0; }
  bool Within() const {
    const double wider = kChance * Chance();
    return Relative() > kLeastChi2 - wider && Relative() < kMostChi2 + wider;
  }
};

void CheckChi2(const Fit& fit, const Structure& structure, const Observations& observations,
               std::vector<Weakness>& failures) {
  std::map<PanelId, Chi2> panels;
  std::map<int, Chi2> views;
  Chi2 all;
  const auto residuals = WhitenedResiduals(fit.state, structure, observations);
  const auto for_points = [&](const auto& add) {
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
        if (!fit.weighting.inlier[i][static_cast<std::size_t>(k)]) continue;
        add(observations.photos[i], residuals[i].col(k).squaredNorm());
      }
    }
  };
  for_points([&](const PanelPhoto& photo, double squared) {
    for (Chi2* chi2 : {&all, &panels[photo.panel]}) {
      chi2->is += squared;
      ++chi2->num;
    }
  });
  if (!(all.is > 0)) return;
  for (auto& [panel, chi2] : panels) {
    chi2.expected = all.is * chi2.num / all.num;
    if (chi2.Within()) continue;
    failures.push_back(
        {fmt::format("how certain all is: {} fits with {:.2f} times the mean chi^2", NameOf(panel),
                     chi2.Relative()),
         "take that panel's photographs again, in focus and with the others' exposure"});
  }
  for_points([&](const PanelPhoto& photo, double squared) {
    Chi2& view = views[photo.view];
    view.is += squared;
    view.expected += panels[photo.panel].is / panels[photo.panel].num;
    ++view.num;
  });
  for (const auto& [view, chi2] : views) {
    if (chi2.Within()) continue;
    failures.push_back(
        {fmt::format("how certain all is: view {} fits with {:.2f} times the mean chi^2", view + 1,
                     chi2.Relative()),
         fmt::format("take position {} again, or leave its photographs out", view + 1)});
  }
}

void CheckCells(const Fit& fit, const Structure& structure, const Observations& observations,
                std::vector<Weakness>& failures) {
  for (const ResidualMap& map : MapResiduals(fit, structure, observations)) {
    const ResidualCell* worst = nullptr;
    int column = 0, row = 0;
    for (int y = 0; y < ResidualMap::kRows; ++y) {
      for (int x = 0; x < ResidualMap::kColumns; ++x) {
        const ResidualCell& cell = map.At(x, y);
        if (cell.num_points == 0 || (worst && cell.mean_px.norm() <= worst->mean_px.norm())) {
          continue;
        }
        // Of the mean of so many points, were they independent; the mean's two parts together.
        const double chance = cell.rms_px / std::sqrt(cell.num_points);
        if (cell.mean_px.norm() <= kLargestCellPx + kChance * chance) continue;
        worst = &cell;
        column = x;
        row = y;
      }
    }
    if (worst == nullptr) continue;
    failures.push_back(
        {fmt::format("rays through a part of {}: around column {:.0f}, row {:.0f} it is off by "
                     "{:.3f} px from what the model allows",
                     NameOf(map.panel),
                     (column + 0.5) / ResidualMap::kColumns * structure.Panel(map.panel).width_px,
                     (row + 0.5) / ResidualMap::kRows * structure.Panel(map.panel).height_px,
                     worst->mean_px.norm()),
         "photograph that panel's sinusoids as well (--mode precise) from 3 or 4 of the positions; "
         "look for glare there and at the display's gap_mm and index"});
  }
}

void CheckHeldOut(const Fit& fit, const Structure& structure, const Observations& observations,
                  std::vector<Weakness>& failures) {
  constexpr std::size_t kEnoughViews = 6;  // that three fourths of them carry a display
  if (structure.views.size() < kEnoughViews) return;
  const std::vector<double> squares = HeldOutSquares(fit, structure, observations);
  double sum = 0;
  for (const double square : squares) sum += square;
  const auto num = static_cast<double>(squares.size());
  if (!(num > 0 && fit.variance > 0)) return;
  const double ratio = std::sqrt(sum / (2 * num) / fit.variance);
  if (ratio <= kMostHeldOut + kChance / (2 * std::sqrt(num))) return;
  failures.push_back(
      {fmt::format("rays from new directions: views left out are predicted with {:.2f} times the "
                   "error of the fit ({} is the most)",
                   ratio, kMostHeldOut),
       "add photographs of all panels between the positions so far, up to 12 positions"});
}

}  // namespace

std::vector<Weakness> Contradictions(const Fit& fit, const Structure& structure,
                                     const Observations& observations) {
  std::vector<Weakness> failures;
  CheckSlip(fit, failures);
  CheckChi2(fit, structure, observations, failures);
  CheckCells(fit, structure, observations, failures);
  CheckHeldOut(fit, structure, observations, failures);
  return failures;
}

}  // namespace lamella
