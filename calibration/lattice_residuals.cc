#include "calibration/lattice_residuals.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr int kColumns = ResidualMap::kColumns, kRows = ResidualMap::kRows;
constexpr int kFewestOfAQuarter = 20;  // samples of a quarter

struct Mean {
  double sum = 0, squares = 0;
  int count = 0, left_out = 0;
  double value() const { return sum / count; }
};
using Quarters = std::array<Mean, 4>;
using Parts = std::array<Quarters, ResidualMap::kCells>;  // row by row from the top left

// The panel's size before its middle, mm.
Vector2d HalfOf(const PanelCalibration& panel) {
  const double pixel = panel.pitch_mm * (1 + panel.scale);
  return pixel / 2 * Vector2d(panel.width_px, panel.height_px);
}

Parts PartsOf(const std::vector<SheetRay>& rays, const LatticeModel& model, int family, double most,
              const Vector2d& half) {
  Parts parts{};
  const auto place = [](double share, int count) {
    return static_cast<std::size_t>(std::clamp(std::floor(share * count), 0.0, count - 1.0));
  };
  for (const SheetRay& ray : rays) {
    const std::size_t x = place((half.x() + ray.sheet.x()) / (2 * half.x()), 2 * kColumns);
    const std::size_t y = place((half.y() - ray.sheet.y()) / (2 * half.y()), 2 * kRows);
    Mean& mean = parts[y / 2 * kColumns + x / 2][y % 2 * 2 + x % 2];
    const LatticeModel::Residual r = model.ResidualOf(ray, model.CentreOf(ray), family);
    if (!(std::abs(r.mm) < most * r.sigma)) {
      ++mean.left_out;
      continue;
    }
    mean.sum += r.mm;
    mean.squares += r.mm * r.mm;
    ++mean.count;
  }
  return parts;
}

Mean SumOf(const Quarters& quarters) {
  Mean all;
  for (const Mean& quarter : quarters) {
    all.sum += quarter.sum;
    all.squares += quarter.squares;
    all.count += quarter.count;
    all.left_out += quarter.left_out;
  }
  return all;
}

// Residuals across one family, seen less expected, on top of those of the families before it.
void AddToMap(const Parts& parts, const LatticeModel& model, int family, double pixel_mm,
              ResidualMap& map) {
  const Vector2d normal(model.Normal(family).x(), -model.Normal(family).y());  // down
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Mean of = SumOf(parts[i]);
    ResidualCell& cell = map.cells[i];
    // What counts in every family: the fewest.
    cell.num_points = family == 0 ? of.count : std::min(cell.num_points, of.count);
    cell.num_left_out = std::max(cell.num_left_out, of.left_out);
    if (of.count == 0) continue;
    const double weight = model.FamilyWeight();
    cell.mean_px += weight * of.value() / pixel_mm * normal;
    const double square = weight * of.squares / of.count / (pixel_mm * pixel_mm);
    cell.rms_px = std::sqrt(cell.rms_px * cell.rms_px + square);
  }
}

bool IsFull(const Quarters& quarters) {
  return std::all_of(quarters.begin(), quarters.end(),
                     [](const Mean& mean) { return mean.count >= kFewestOfAQuarter; });
}

}  // namespace

LatticeMisfit MisfitOf(const std::vector<SheetRay>& rays, const LatticeModel& model, double most,
                       const PanelCalibration& panel) {
  LatticeMisfit misfit;
  misfit.map.cells.resize(ResidualMap::kCells);
  const Vector2d half = HalfOf(panel);
  double squares = 0;
  int degrees = 0;
  for (int a = 0; a < model.num_families(); ++a) {
    const Parts parts = PartsOf(rays, model, a, most, half);
    AddToMap(parts, model, a, panel.pitch_mm, misfit.map);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Quarters& quarters = parts[i];
      if (!IsFull(quarters)) continue;
      double mean = 0;
      for (const Mean& quarter : quarters) mean += quarter.value() / 4;
      for (const Mean& quarter : quarters) squares += std::pow(quarter.value() - mean, 2);
      degrees += 3;
      if (std::abs(mean) <= misfit.largest_mm) continue;
      misfit.largest_mm = std::abs(mean);
      const std::size_t column = i % kColumns, row = i / kColumns;
      const Vector2d side(2 * (static_cast<double>(column) + 0.5) / kColumns - 1,
                          1 - 2 * (static_cast<double>(row) + 0.5) / kRows);
      misfit.place_mm = half.cwiseProduct(side);
    }
  }
  // A part's mean is that of four quarters.
  if (degrees > 0) misfit.deviation_mm = std::sqrt(squares / degrees / 4);
  return misfit;
}

std::vector<FitOf> FitsOfViews(const std::vector<SheetRay>& rays, const LatticeModel& model,
                               double most, std::size_t num_views, double pixel_mm) {
  std::vector<FitOf> views(num_views);
  const double weight = model.FamilyWeight() / model.num_directions();
  for (const SheetRay& ray : rays) {
    FitOf& view = views[static_cast<std::size_t>(ray.view)];
    ++view.num_points;
    double squares = 0, chi2 = 0, bound = most;
    for (int a = 0; a < model.num_families(); ++a) {
      const LatticeModel::Residual r = model.ResidualOf(ray, model.CentreOf(ray), a);
      squares += weight * std::pow(r.mm / pixel_mm, 2);
      chi2 += weight * std::pow(r.mm / r.sigma, 2);
      bound = std::min(bound, model.SpacingMm() / 2 / r.sigma);
    }
    if (model.num_directions() * chi2 >= bound * bound) continue;
    ++view.num_used;
    view.rms_px += squares;
    view.chi2 += chi2;
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].name = fmt::format("view {}", i + 1);
    if (views[i].num_used == 0) continue;
    views[i].rms_px = std::sqrt(views[i].rms_px / views[i].num_used);
    views[i].chi2 /= views[i].num_used;
  }
  return views;
}

}  // namespace lamella
