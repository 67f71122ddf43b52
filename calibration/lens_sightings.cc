#include "calibration/lens_sightings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "calibration/homography.h"
#include "calibration/lens_shares.h"
#include "calibration/place_grid.h"
#include "lightfield/median.h"
#include "lightfield/panel_rays.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewestLenses = 12, kMostSingle = 400;
constexpr double kAround = 2.1;  // lens pitches: 19 lenses of a hexagonal sheet, 13 of a square one
constexpr double kMostDeviations = 4;  // deviations
constexpr double kMostSpreadPx = 1;    // of the panel, seen through one lens

// The photograph's pixels that see one lens.
struct Patch {
  Vector2d lens_px;          // its centre, of the panel
  std::vector<double> x, y;  // of the pixels
  std::vector<double> u, v;  // that they see

  // Takes out pixels that see anything but what most do: wrong fringes, and seams that see two
  // lenses. Seams are as wide to all sides.
  void KeepWhatAgrees() {
    const double u0 = Median(u), v0 = Median(v);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (std::max(std::abs(u[i] - u0), std::abs(v[i] - v0)) > kMostSpreadPx) continue;
      x[kept] = x[i];
      y[kept++] = y[i];
    }
    x.resize(kept);
    y.resize(kept);
  }
};

std::vector<Patch> PatchesOf(const ScreenMap& map, const PanelCalibration& panel,
                             const LensLattice& lattice) {
  std::map<std::pair<long, long>, Patch> patches;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.valid(x, y) == 0) continue;
      const Vector2d seen(static_cast<double>(map.u_px(x, y)), static_cast<double>(map.v_px(x, y)));
      const Vector2d centre = NearestLens(lattice, PanelPoint(panel, seen).head<2>());
      const auto pixel = PanelPixel(panel, centre);
      if (!pixel) continue;
      Patch& patch = patches[{std::lround(8 * pixel->y()), std::lround(8 * pixel->x())}];
      patch.lens_px = *pixel;
      patch.x.push_back(x + 0.5);
      patch.y.push_back(y + 0.5);
      patch.u.push_back(seen.x());
      patch.v.push_back(seen.y());
    }
  }
  std::vector<Patch> all;
  for (auto& [key, patch] : patches) {
    patch.KeepWhatAgrees();
    if (!patch.x.empty()) all.push_back(std::move(patch));
  }
  return all;
}

struct SeenLens {
  Vector2d lens_px, image_px;
};

// The middle of a patch's pixels without what lies far off it, wrong fringes of other lenses;
// nothing where all do.
std::optional<Vector2d> RoughMiddle(const Patch& patch, double most_off_px) {
  const Vector2d median(Median(patch.x), Median(patch.y));
  Vector2d sum(0, 0);
  double num = 0;
  for (std::size_t i = 0; i < patch.x.size(); ++i) {
    const Vector2d at(patch.x[i], patch.y[i]);
    if ((at - median).cwiseAbs().maxCoeff() > most_off_px) continue;
    sum += at;
    num += 1;
  }
  if (num == 0) return std::nullopt;
  return Vector2d(sum / num);
}

// Of each patch its neighbours, if it is seen about as whole as most and has them on all sides:
// what lies beside lenses that end at the dark is not told apart. Else none.
std::vector<std::vector<std::size_t>> NeighboursOfWhole(const std::vector<Patch>& patches,
                                                        LensLattice::Type type, double pitch_px,
                                                        double whole) {
  const std::size_t all_around = type == LensLattice::Type::kHexagonal ? 6 : 8;
  // Across the corners of square lenses, too, of those that are seen by half at least.
  std::vector<std::size_t> numbers;
  std::vector<Vector2d> places;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (static_cast<double>(patches[i].x.size()) < 0.5 * whole) continue;
    numbers.push_back(i);
    places.push_back(patches[i].lens_px);
  }
  const PlaceGrid grid(places, 1.6 * pitch_px);
  std::vector<std::vector<std::size_t>> neighbours(patches.size());
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const std::size_t i = numbers[k];
    if (static_cast<double>(patches[i].x.size()) < 0.75 * whole) continue;
    for (const std::size_t other : grid.Within(places[k])) {
      if ((places[other] - places[k]).norm() > 0.5 * pitch_px) {
        neighbours[i].push_back(numbers[other]);
      }
    }
    if (neighbours[i].size() < all_around) neighbours[i].clear();
  }
  return neighbours;
}

// Of those with neighbours.
std::vector<std::optional<Vector2d>> MiddlesByShares(
    const ScreenMap& map, const std::vector<LensInPhoto>& lenses,
    const std::vector<std::vector<std::size_t>>& neighbours) {
  std::vector<std::optional<Vector2d>> middles(lenses.size());
  ParallelForEach(0, static_cast<std::int64_t>(lenses.size()), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    if (neighbours[i].empty()) return;
    std::vector<LensInPhoto> around;
    for (const std::size_t j : neighbours[i]) around.push_back(lenses[j]);
    middles[i] = MiddleByShares(map, lenses[i], around);
  });
  return middles;
}

// Of all whole lenses, their middles from rough ones and then again from these.
std::vector<SeenLens> WholeLenses(const ScreenMap& map, const PanelCalibration& panel,
                                  const LensLattice& lattice, double pitch_px) {
  const std::vector<Patch> patches = PatchesOf(map, panel, lattice);
  if (patches.size() < kFewestLenses) return {};
  std::vector<double> sizes;
  for (const Patch& patch : patches) sizes.push_back(static_cast<double>(patch.x.size()));
  // Of all sizes the upper quartile: a rim of lenses is seen in part.
  const auto whole = sizes.begin() + static_cast<std::ptrdiff_t>(3 * sizes.size() / 4);
  std::nth_element(sizes.begin(), whole, sizes.end());
  const double width_px = std::sqrt(*whole);
  std::vector<LensInPhoto> in_photo;
  for (const Patch& patch : patches) {
    const auto middle = RoughMiddle(patch, width_px);
    in_photo.push_back(middle ? LensAt(map, *middle, width_px) : LensInPhoto());
  }
  const auto neighbours = NeighboursOfWhole(patches, lattice.type, pitch_px, *whole);
  const auto first = MiddlesByShares(map, in_photo, neighbours);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (first[i]) in_photo[i] = LensAt(map, *first[i], width_px);
  }
  const auto middles = MiddlesByShares(map, in_photo, neighbours);
  std::vector<SeenLens> lenses;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (middles[i]) lenses.push_back({patches[i].lens_px, *middles[i]});
  }
  return lenses;
}

// What lenses are off the homography of all, px; nothing without one.
std::vector<Vector2d> OffHomography(const std::vector<SeenLens>& lenses,
                                    const Eigen::Matrix3d& homography) {
  std::vector<Vector2d> off;
  for (const SeenLens& lens : lenses) {
    off.emplace_back(lens.image_px - (homography * lens.lens_px.homogeneous()).hnormalized());
  }
  return off;
}

// An affine field around a lens: its value there, and what its lenses are off it.
struct LocalFit {
  Vector2d value{0, 0};
  double variance_share = 0;  // of the value, in variances of one lens
  std::vector<double> squares;
  double freedom = 0;
};

LocalFit FitAround(std::size_t number, const std::vector<SeenLens>& lenses, const PlaceGrid& grid,
                   const std::vector<Vector2d>& off, double radius_px) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  std::vector<std::pair<Vector3d, Vector2d>> rows;
  for (const std::size_t j : grid.Within(lenses[number].lens_px)) {
    const Vector2d step = (lenses[j].lens_px - lenses[number].lens_px) / radius_px;
    rows.emplace_back(step.homogeneous(), off[j]);
    information += rows.back().first * rows.back().first.transpose();
    right += rows.back().first * off[j].transpose();
  }
  LocalFit fit;
  fit.freedom = static_cast<double>(rows.size()) - 3;
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(information);
  if (fit.freedom < 2 || !(information.determinant() > 1e-6)) return {};
  const Eigen::Matrix<double, 3, 2> field = ldlt.solve(right);
  fit.value = field.row(2).transpose();
  fit.variance_share = ldlt.solve(Vector3d::UnitZ()).z();
  for (const auto& [row, value] : rows) {
    fit.squares.push_back((field.transpose() * row - value).squaredNorm() / 2);
  }
  return fit;
}

// Far enough apart to share no lens.
bool IsApart(const Vector2d& at, const std::vector<Observation>& points, double distance_px) {
  return std::all_of(points.begin(), points.end(), [&](const Observation& point) {
    return (point.panel_px - at).norm() > distance_px;
  });
}

}  // namespace

std::vector<Observation> ObserveLenses(const ScreenMap& map, const PanelCalibration& panel,
                                       const LensLattice& lattice) {
  const double pitch_px = lattice.pitch_mm / (panel.pitch_mm * (1 + panel.scale));
  const std::vector<SeenLens> lenses = WholeLenses(map, panel, lattice, pitch_px);
  if (lenses.size() < kFewestLenses) return {};
  Eigen::Matrix2Xd from(2, static_cast<Eigen::Index>(lenses.size())), to = from;
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = lenses[i].lens_px;
    to.col(static_cast<Eigen::Index>(i)) = lenses[i].image_px;
  }
  const auto homography = FitHomography(from, to);
  if (!homography) return {};
  const std::vector<Vector2d> off = OffHomography(lenses, *homography);
  const double radius_px = kAround * pitch_px;
  std::vector<Vector2d> places;
  for (const SeenLens& lens : lenses) places.push_back(lens.lens_px);
  const PlaceGrid grid(places, radius_px);
  std::vector<LocalFit> fits;
  std::vector<double> variances;  // of one lens, by each fit
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    fits.push_back(FitAround(i, lenses, grid, off, radius_px));
    double sum = 0;
    for (const double square : fits.back().squares) sum += square;
    if (fits.back().freedom > 0) variances.push_back(sum / fits.back().freedom);
  }
  if (variances.empty()) return {};
  const double variance = std::max(Median(variances), 1e-8);
  const bool single = lenses.size() <= kMostSingle;
  std::vector<Observation> points;
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    const LocalFit& fit = fits[i];
    if (!(fit.freedom > 0)) continue;
    const bool fits_in =
        (off[i] - fit.value).squaredNorm() < 2 * kMostDeviations * kMostDeviations * variance;
    if (!fits_in) continue;
    if (single) {
      points.push_back(
          {lenses[i].lens_px, lenses[i].image_px, variance * Eigen::Matrix2d::Identity()});
    } else if (IsApart(lenses[i].lens_px, points, 2 * radius_px)) {
      points.push_back({lenses[i].lens_px, lenses[i].image_px - off[i] + fit.value,
                        variance * fit.variance_share * Eigen::Matrix2d::Identity()});
    }
  }
  return points;
}

}  // namespace lamella
