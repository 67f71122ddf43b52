#include "calibration/lattice_search.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector2d;

constexpr double kMostPitchOff = 0.015, kMostRotationOff = 0.0262;  // 1.5 %, 1.5 degrees
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kMostWork = 1e8;          // terms of the periodogram
constexpr std::size_t kMostForGap = 6000;  // samples
constexpr double kMostGapOff = 1.0 / 3;

Complex Turn(double turns) { return std::polar(1.0, kTwoPi * turns); }

// Every so many-th ray, so that about `most` are left.
std::vector<SheetRay> Thinned(const std::vector<SheetRay>& rays, std::size_t most) {
  std::vector<SheetRay> chosen;
  const std::size_t count = std::min(most, rays.size());
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(rays[i * rays.size() / count]);
  return chosen;
}

// Frequencies about the design's, (first + i) steps along its normal and (first + j) along its
// lenses: half the resolution of samples that extend so far.
struct Grid {
  double step_along = 0, step_across = 0;  // per mm
  int half_along = 0, half_across = 0;
  int columns() const { return 2 * half_across + 1; }
  std::size_t size() const {
    return static_cast<std::size_t>(2 * half_along + 1) * static_cast<std::size_t>(columns());
  }
  std::size_t Index(int i, int j) const {
    return static_cast<std::size_t>(i + half_along) * static_cast<std::size_t>(columns()) +
           static_cast<std::size_t>(j + half_across);
  }
};

// Lens centres in a family's own axes: along its normal and along its lenses. In these all families
// have one frequency.
std::vector<Vector2d> CentresAlong(const std::vector<SheetRay>& rays, const LatticeModel& model,
                                   int family) {
  const Vector2d& n = model.Normal(family);
  const Vector2d t(-n.y(), n.x());
  std::vector<Vector2d> centres;
  centres.reserve(rays.size());
  for (const SheetRay& ray : rays) {
    const Vector2d c = model.CentreOf(ray);
    centres.emplace_back(n.dot(c), t.dot(c));
  }
  return centres;
}

Grid GridFor(const std::vector<SheetRay>& rays, const LatticeModel& model) {
  Vector2d extent(0, 0);
  for (int a = 0; a < model.num_families(); ++a) {
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vector2d& c : CentresAlong(rays, model, a)) {
      low = low.cwiseMin(c);
      high = high.cwiseMax(c);
    }
    extent = extent.cwiseMax(high - low);
  }
  const double P = model.SpacingMm();
  extent = extent.cwiseMax(P);
  Grid grid{1 / (2 * extent.x()), 1 / (2 * extent.y()), 0, 0};
  grid.half_along = static_cast<int>(std::ceil(kMostPitchOff / P / grid.step_along)) + 1;
  grid.half_across = static_cast<int>(std::ceil(kMostRotationOff / P / grid.step_across)) + 1;
  return grid;
}

// Adds |sum|^2 / samples of one view and family to the power at every frequency.
void AddPower(const std::vector<Vector2d>& centres, const std::vector<SheetRay>& rays, int view,
              double frequency, const Grid& grid, std::vector<double>& power) {
  std::vector<Complex> sums(grid.size());
  double count = 0;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (rays[r].view != view) continue;
    ++count;
    const Vector2d& c = centres[r];
    const Complex along = Turn(grid.step_along * c.x()), across = Turn(grid.step_across * c.y());
    Complex row = Turn((frequency - grid.half_along * grid.step_along) * c.x() -
                       grid.half_across * grid.step_across * c.y());
    auto sum = sums.begin();
    for (int i = -grid.half_along; i <= grid.half_along; ++i, row *= along) {
      Complex term = row;
      for (int j = -grid.half_across; j <= grid.half_across; ++j, term *= across) *sum++ += term;
    }
  }
  if (count == 0) return;
  for (std::size_t i = 0; i < sums.size(); ++i) power[i] += std::norm(sums[i]) / count;
}

Error NotFound(const char* what) {
  return InputError(
      "lens sheet", what,
      "check that the display's file has the sheet's type, pitch (to 1.5 %) and "
      "rotation (to 1.5 degrees), and that the cameras are where they are said to be");
}

// Pitch and rotation of the highest power.
Vector5d FindPitch(const std::vector<SheetRay>& all, int num_views, const LatticeModel& model) {
  const Grid grid = GridFor(all, model);
  const double terms = static_cast<double>(grid.size()) * model.num_families();
  const auto rays = Thinned(all, static_cast<std::size_t>(std::max(1000.0, kMostWork / terms)));
  const double frequency = 1 / model.SpacingMm();
  std::vector<double> power(grid.size(), 0.0);
  for (int a = 0; a < model.num_families(); ++a) {
    const std::vector<Vector2d> centres = CentresAlong(rays, model, a);
    for (int view = 0; view < num_views; ++view) {
      AddPower(centres, rays, view, frequency, grid, power);
    }
  }
  const auto best = std::max_element(power.begin(), power.end());
  // Without a lattice each view and family adds 1 on the mean; the largest of a million stays
  // below.
  if (*best < 30 + 3.0 * num_views * model.num_families()) {
    throw NotFound("no lattice like the design's is seen");
  }
  const int index = static_cast<int>(best - power.begin());
  const int i = index / grid.columns() - grid.half_along;
  const int j = index % grid.columns() - grid.half_across;
  if (std::abs(i) == grid.half_along || std::abs(j) == grid.half_across) {
    throw NotFound("its lattice is further from the design's than 1.5 % or 1.5 degrees");
  }
  const Vector2d found(frequency + i * grid.step_along, j * grid.step_across);
  Vector5d at = model.parameters();
  at(kLatticePitch) *= frequency / found.norm();
  at(kLatticeRotation) += std::atan2(found.y(), found.x());
  return at;
}

double MeanDistance(const std::vector<Eigen::Vector3d>& eyes) {
  double sum = 0;
  for (const Eigen::Vector3d& eye : eyes) sum += eye.z();
  return sum / static_cast<double>(eyes.size());
}

// Of each family, over all views.
std::vector<Complex> SumsOf(const std::vector<SheetRay>& rays, const LatticeModel& model) {
  std::vector<Complex> sums;
  for (int a = 0; a < model.num_families(); ++a) {
    const Vector2d n = model.Normal(a) / model.SpacingMm();
    Complex sum = 0;
    for (const SheetRay& ray : rays) sum += Turn(n.dot(model.CentreOf(ray)));
    sums.push_back(sum);
  }
  return sums;
}

// How much slopes differ among the rays, as standard deviation.
double SpreadOfSlopes(const std::vector<SheetRay>& rays) {
  Vector2d mean(0, 0), squares(0, 0);
  for (const SheetRay& ray : rays) {
    mean += ray.slope;
    squares += ray.slope.cwiseAbs2();
  }
  const auto n = static_cast<double>(rays.size());
  return std::sqrt(std::max(0.0, (squares / n - (mean / n).cwiseAbs2()).sum()));
}

}  // namespace

Vector5d FindLattice(const std::vector<SheetRay>& rays, const std::vector<Eigen::Vector3d>& eyes,
                     const LatticeModel& design) {
  if (rays.empty()) throw NotFound("no pixel of the photographs shows the panel");
  const Vector5d start = FindPitch(rays, static_cast<int>(eyes.size()), design);
  const std::vector<SheetRay> few = Thinned(rays, kMostForGap);
  const double gap = start(kLatticeGap), distance = MeanDistance(eyes);
  // Slopes that differ by their spread turn by an eighth from step to step.
  const double reach = kMostGapOff * gap;
  const double turns = reach * SpreadOfSlopes(few) / design.At(start).SpacingMm();
  const int half = std::clamp(static_cast<int>(std::ceil(8 * turns)), 1, 200);
  Vector5d best = start;
  double highest = 0;
  for (int step = 0; step <= 2 * half; ++step) {  // the nearest to the design first: 0, 1, -1, 2
    const int i = step % 2 == 1 ? (step + 1) / 2 : -step / 2;
    Vector5d at = start;
    at(kLatticeGap) = gap + i * reach / half;
    // What the views show is P (1 + f/D).
    at(kLatticePitch) *= (1 + gap / distance) / (1 + at(kLatticeGap) / distance);
    const std::vector<Complex> sums = SumsOf(few, design.At(at));
    double power = 0;
    for (const Complex& sum : sums) power += std::norm(sum);
    if (power <= 1.001 * highest) continue;
    highest = power;
    at(kLatticePhase0) = std::arg(sums[0]) / kTwoPi;
    if (sums.size() > 1) at(kLatticePhase1) = std::arg(sums[1]) / kTwoPi;
    best = at;
  }
  return best;
}

}  // namespace lamella
