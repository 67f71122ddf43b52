#include "calibration/lattice_residuals.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr int kColumns = 8, kRows = 5;
constexpr int kFewestOfAQuarter = 20;  // samples of a quarter

struct Mean {
  double sum = 0;
  int count = 0;
  double value() const { return sum / count; }
};
using Quarters = std::array<Mean, 4>;
using Parts = std::array<Quarters, kColumns * kRows>;

struct Extent {
  Vector2d low, high;
};

Extent ExtentOf(const std::vector<SheetRay>& rays) {
  Extent extent{rays[0].sheet, rays[0].sheet};
  for (const SheetRay& ray : rays) {
    extent.low = extent.low.cwiseMin(ray.sheet);
    extent.high = extent.high.cwiseMax(ray.sheet);
  }
  return extent;
}

Parts PartsOf(const std::vector<SheetRay>& rays, const LatticeModel& model, int family, double most,
              const Extent& extent) {
  Parts parts{};
  for (const SheetRay& ray : rays) {
    const LatticeModel::Residual r = model.ResidualOf(ray, model.CentreOf(ray), family);
    if (!(std::abs(r.mm) < most * r.sigma)) continue;
    const Vector2d share =
        (ray.sheet - extent.low).cwiseQuotient((extent.high - extent.low).cwiseMax(1e-9));
    const auto x = static_cast<std::size_t>(std::min(2 * kColumns - 1.0, 2 * kColumns * share.x()));
    const auto y = static_cast<std::size_t>(std::min(2 * kRows - 1.0, 2 * kRows * share.y()));
    Mean& mean = parts[y / 2 * kColumns + x / 2][y % 2 * 2 + x % 2];
    mean.sum += r.mm;
    ++mean.count;
  }
  return parts;
}

}  // namespace

LatticeMisfit MisfitOf(const std::vector<SheetRay>& rays, const LatticeModel& model, double most) {
  LatticeMisfit misfit;
  const Extent extent = ExtentOf(rays);
  double squares = 0;
  int degrees = 0;
  for (int a = 0; a < model.num_families(); ++a) {
    const Parts parts = PartsOf(rays, model, a, most, extent);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Quarters& quarters = parts[i];
      if (std::any_of(quarters.begin(), quarters.end(),
                      [](const Mean& mean) { return mean.count < kFewestOfAQuarter; })) {
        continue;
      }
      double mean = 0;
      for (const Mean& quarter : quarters) mean += quarter.value() / 4;
      for (const Mean& quarter : quarters) squares += std::pow(quarter.value() - mean, 2);
      degrees += 3;
      if (std::abs(mean) <= misfit.largest_mm) continue;
      misfit.largest_mm = std::abs(mean);
      const std::size_t column = i % kColumns, row = i / kColumns;
      const Vector2d share((static_cast<double>(column) + 0.5) / kColumns,
                           (static_cast<double>(row) + 0.5) / kRows);
      misfit.place_mm = extent.low + share.cwiseProduct(extent.high - extent.low);
    }
  }
  // A part's mean is that of four quarters.
  if (degrees > 0) misfit.deviation_mm = std::sqrt(squares / degrees / 4);
  return misfit;
}

}  // namespace lamella
