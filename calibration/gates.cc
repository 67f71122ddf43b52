#include "calibration/gates.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "calibration/held_out.h"
#include "calibration/residual_map.h"

namespace lamella {
namespace {

constexpr double kLargestSlipPx = 0.05, kLargestLeftOut = 0.35;
constexpr double kLeastChi2 = 0.7, kMostChi2 = 1.5, kMostHeldOut = 1.3;
constexpr double kChance = 4;  // standard deviations
// chi^2 of a point below which residuals are what rounding leaves: a hundredth of its deviation.
constexpr double kRounding = 1e-4;

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
  if (!(all.is > kRounding * all.num)) return;
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

// By how much a cell is off, in units of what is allowed: its mean of 0.03 px, or points left out
// beyond a third of them and beyond what chance does to the panel's share of them.
double Excess(const ResidualCell& cell, double panel_left_out) {
  const double num = cell.num_points + cell.num_left_out;
  if (!(num > 0)) return 0;
  const double spread = std::sqrt(num * panel_left_out * (1 - panel_left_out));
  const double left_out =
      cell.num_left_out /
      std::max({kLargestLeftOut * num, num * panel_left_out + kChance * spread, 4.0});
  if (cell.num_points == 0) return left_out;
  return std::max(left_out, cell.mean_px.norm() / std::hypot(kLargestMeanPx, cell.ChancePx()));
}

double LeftOut(const ResidualMap& map) {
  double num = 0, left_out = 0;
  for (const ResidualCell& cell : map.cells) {
    num += cell.num_points + cell.num_left_out;
    left_out += cell.num_left_out;
  }
  return num > 0 ? left_out / num : 0;
}

void CheckCells(const Fit& fit, const Structure& structure, const Observations& observations,
                std::vector<Weakness>& failures) {
  for (const ResidualMap& map : MapResiduals(fit, structure, observations)) {
    const double left_out = LeftOut(map);
    const auto worst = std::max_element(map.cells.begin(), map.cells.end(),
                                        [&](const ResidualCell& a, const ResidualCell& b) {
                                          return Excess(a, left_out) < Excess(b, left_out);
                                        });
    if (worst == map.cells.end() || !(Excess(*worst, left_out) > 1)) continue;
    const auto place = static_cast<int>(worst - map.cells.begin());
    const int column = place % ResidualMap::kColumns, row = place / ResidualMap::kColumns;
    const PanelCalibration& panel = structure.Panel(map.panel);
    failures.push_back(
        {fmt::format(
             "rays through a part of {}: around its column {:.0f} and row {:.0f} points are "
             "off by {:.3f} px on the mean, and {} of {} were left out",
             NameOf(map.panel), (column + 0.5) / ResidualMap::kColumns * panel.width_px,
             (row + 0.5) / ResidualMap::kRows * panel.height_px, worst->mean_px.norm(),
             worst->num_left_out, worst->num_points + worst->num_left_out),
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
