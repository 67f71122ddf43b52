#include "calibration/lens_shares.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <Eigen/Cholesky>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kCoreRadius = 0.35;  // of a lens, where it is seen alone, in its widths
// How far across a seam its blur is followed: in lens widths, but no more than this.
constexpr double kReach = 0.4, kMostReachPx = 3;

VectorXd LightOf(const ScreenMap& map, int x, int y) {
  VectorXd light(2 * static_cast<Eigen::Index>(map.sinusoids.size()));
  Eigen::Index row = 0;
  for (const auto& sinusoid : map.sinusoids) {
    light[row++] = static_cast<double>(sinusoid(x, y).real());
    light[row++] = static_cast<double>(sinusoid(x, y).imag());
  }
  return light;
}

bool IsDark(const ScreenMap& map, int x, int y) {
  return std::any_of(map.sinusoids.begin(), map.sinusoids.end(), [&](const auto& sinusoid) {
    return sinusoid(x, y) == std::complex<float>(0, 0);
  });
}

// Pixels whose centres are within a distance of a point along both axes; empty where some are
// outside of the photograph.
Rect PixelsAround(const ScreenMap& map, const Vector2d& at, double distance) {
  const int x0 = static_cast<int>(std::ceil(at.x() - distance - 0.5));
  const int y0 = static_cast<int>(std::ceil(at.y() - distance - 0.5));
  const int x1 = static_cast<int>(std::floor(at.x() + distance - 0.5));
  const int y1 = static_cast<int>(std::floor(at.y() + distance - 0.5));
  if (x0 < 0 || y0 < 0 || x1 >= map.width() || y1 >= map.height()) return {};
  return {x0, y0, x1 - x0 + 1, y1 - y0 + 1};
}

// How far beyond the seam to a neighbour a pixel is.
double Beyond(const Vector2d& at, const Vector2d& middle, const Vector2d& neighbour) {
  return ((at - middle).squaredNorm() - (at - neighbour).squaredNorm()) /
         (2 * (neighbour - middle).norm());
}

// The first one's share in light that is the sum of some; nothing where they are not told apart.
std::optional<double> FirstShare(const VectorXd& light, const std::vector<const VectorXd*>& of) {
  constexpr double kLeastRcond = 1e-4;
  const auto num = static_cast<Eigen::Index>(of.size());
  Eigen::MatrixXd lights(light.size(), num);
  for (Eigen::Index k = 0; k < num; ++k) lights.col(k) = *of[static_cast<std::size_t>(k)];
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(lights.transpose() * lights);
  if (!(ldlt.rcond() > kLeastRcond)) return std::nullopt;
  return ldlt.solve(lights.transpose() * light)[0];
}

}  // namespace

LensInPhoto LensAt(const ScreenMap& map, const Vector2d& middle_px, double width_px) {
  LensInPhoto lens{middle_px};
  const double radius = std::max(kCoreRadius * width_px, 0.75);
  const Rect around = PixelsAround(map, middle_px, radius);
  VectorXd sum = VectorXd::Zero(2 * static_cast<Eigen::Index>(map.sinusoids.size()));
  double total = 0;
  for (int y = around.y; y < around.y + around.height; ++y) {
    for (int x = around.x; x < around.x + around.width; ++x) {
      const double inside =
          1 - (Vector2d(x + 0.5, y + 0.5) - middle_px).squaredNorm() / (radius * radius);
      if (inside <= 0) continue;
      if (IsDark(map, x, y)) return lens;
      sum += inside * inside * LightOf(map, x, y);
      total += inside * inside;
    }
  }
  if (total > 0) lens.light = sum / total;
  return lens;
}

std::optional<Vector2d> MiddleByShares(const ScreenMap& map, const LensInPhoto& lens,
                                       const std::vector<LensInPhoto>& neighbours) {
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (const LensInPhoto& other : neighbours) {
    if (other.light.size() == 0) return std::nullopt;
    const double apart = (other.middle_px - lens.middle_px).norm();
    nearest = std::min(nearest, apart);
    farthest = std::max(farthest, apart);
  }
  if (lens.light.size() == 0 || neighbours.empty() || !(nearest > 0)) return std::nullopt;
  const double reach = std::min(kMostReachPx, kReach * nearest);
  const Rect around = PixelsAround(map, lens.middle_px, farthest / 2 + reach);
  if (around.width == 0) return std::nullopt;
  Vector2d sum(0, 0);
  double total = 0;
  std::vector<const VectorXd*> seen;
  for (int y = around.y; y < around.y + around.height; ++y) {
    for (int x = around.x; x < around.x + around.width; ++x) {
      const Vector2d at(x + 0.5, y + 0.5);
      seen = {&lens.light};
      bool beyond = false;
      for (const LensInPhoto& other : neighbours) {
        const double across = Beyond(at, lens.middle_px, other.middle_px);
        beyond = beyond || across > reach;
        if (across > -reach) seen.push_back(&other.light);
      }
      if (beyond) continue;
      if (IsDark(map, x, y)) return std::nullopt;
      const auto share = seen.size() == 1 ? 1.0 : FirstShare(LightOf(map, x, y), seen);
      if (!share) return std::nullopt;
      sum += *share * at;
      total += *share;
    }
  }
  if (!(total > 0)) return std::nullopt;
  return Vector2d(sum / total);
}

}  // namespace lamella
