#include "calibration/lens_shares.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kCoreRadius = 0.35;  // of a lens, where it is seen alone, in its widths
// How far across a seam its blur is followed: in lens widths, but no more than this.
constexpr double kReach = 0.4, kMostReachPx = 3;
constexpr std::size_t kMostNeighbours = 8;  // of a square sheet

// What a pixel shows; false where it is dark or overexposed.
bool GetLight(const ScreenMap& map, int x, int y, VectorXd& light) {
  light.resize(2 * static_cast<Eigen::Index>(map.sinusoids.size()));
  Eigen::Index row = 0;
  for (const auto& sinusoid : map.sinusoids) {
    const std::complex<float> at = sinusoid(x, y);
    if (at == std::complex<float>(0, 0)) return false;
    light[row++] = static_cast<double>(at.real());
    light[row++] = static_cast<double>(at.imag());
  }
  return row > 0;
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

// How far beyond the seam between two lenses a pixel is.
double Beyond(const Vector2d& at, const Vector2d& middle, const Vector2d& other) {
  const Vector2d apart = other - middle;
  return ((at - middle).dot(apart) - 0.5 * apart.squaredNorm()) / apart.norm();
}

// A lens, first, and its neighbours.
class Lenses {
 public:
  Lenses(const LensInPhoto& lens, const std::vector<LensInPhoto>& neighbours) {
    lenses_.push_back(&lens);
    for (const LensInPhoto& other : neighbours) lenses_.push_back(&other);
    const auto num = static_cast<Eigen::Index>(lenses_.size());
    products_.resize(num, num);
    for (Eigen::Index i = 0; i < num; ++i) {
      for (Eigen::Index j = 0; j < num; ++j) products_(i, j) = Light(i).dot(Light(j));
    }
  }

  // Those whose area a pixel is in, or no farther off than `reach`; none where the first is not
  // one.
  void Near(const Vector2d& at, double reach, std::vector<Eigen::Index>& near) const {
    near.clear();
    if (!IsNear(0, at, reach)) return;
    for (Eigen::Index i = 0; i < products_.rows(); ++i) {
      const bool reachable = i == 0 || Beyond(at, Middle(0), Middle(i)) > -reach;
      if (reachable && IsNear(i, at, reach)) near.push_back(i);
    }
  }

  // The first one's share of a pixel that sees some of them. Least squares, with a light hand
  // towards what their places let expect: at corners of square lenses, four sinusoids that are
  // products of two axes' are one too many to be told apart.
  double FirstShare(const Vector2d& at, const VectorXd& light,
                    const std::vector<Eigen::Index>& of) const {
    if (of.size() == 1) return 1;
    constexpr double kTowardsExpected = 0.01;
    const auto num = static_cast<Eigen::Index>(of.size());
    Small<Eigen::Dynamic> products(num, num);
    Small<1> right(num), expected = Expected(at, of);
    for (Eigen::Index i = 0; i < num; ++i) {
      for (Eigen::Index j = 0; j < num; ++j) products(i, j) = products_(Of(of, i), Of(of, j));
      right[i] = Light(Of(of, i)).dot(light);
    }
    const double weight = kTowardsExpected * products.trace() / static_cast<double>(num);
    products.diagonal().array() += weight;
    return products.ldlt().solve(right + weight * expected)[0];
  }

 private:
  static constexpr int kMost = kMostNeighbours + 1;
  template <int kColumns>
  using Small = Eigen::Matrix<double, Eigen::Dynamic, kColumns, 0, kMost,
                              kColumns == Eigen::Dynamic ? kMost : kColumns>;

  static Eigen::Index Of(const std::vector<Eigen::Index>& of, Eigen::Index i) {
    return of[static_cast<std::size_t>(i)];
  }
  bool IsNear(Eigen::Index i, const Vector2d& at, double reach) const {
    for (Eigen::Index j = 0; j < products_.rows(); ++j) {
      if (j != i && Beyond(at, Middle(i), Middle(j)) > reach) return false;
    }
    return true;
  }
  const Vector2d& Middle(Eigen::Index i) const {
    return lenses_[static_cast<std::size_t>(i)]->middle_px;
  }
  const VectorXd& Light(Eigen::Index i) const {
    return lenses_[static_cast<std::size_t>(i)]->light;
  }

  // Of a camera that is neither sharp nor blurred: at a seam a logistic function with the slope of
  // a Gaussian's integral, at square lenses' corners the product of two of them.
  Small<1> Expected(const Vector2d& at, const std::vector<Eigen::Index>& of) const {
    constexpr double kUsualBlurPx = 0.8;
    const double apart = (Middle(Of(of, 1)) - Middle(0)).norm();
    const double scale = 0.5 * std::sqrt(2 * std::numbers::pi) * kUsualBlurPx * apart;
    Small<1> shares(static_cast<Eigen::Index>(of.size()));
    for (Eigen::Index i = 0; i < shares.size(); ++i) {
      shares[i] = ((at - Middle(0)).squaredNorm() - (at - Middle(Of(of, i))).squaredNorm()) / scale;
    }
    shares = (shares.array() - shares.maxCoeff()).exp();
    return shares / shares.sum();
  }

  std::vector<const LensInPhoto*> lenses_;
  Eigen::MatrixXd products_;  // of lights
};

}  // namespace

LensInPhoto LensAt(const ScreenMap& map, const Vector2d& middle_px, double width_px) {
  LensInPhoto lens{middle_px};
  const double radius = std::max(kCoreRadius * width_px, 0.75);
  const Rect around = PixelsAround(map, middle_px, radius);
  VectorXd light, sum = VectorXd::Zero(2 * static_cast<Eigen::Index>(map.sinusoids.size()));
  double total = 0;
  for (int y = around.y; y < around.y + around.height; ++y) {
    for (int x = around.x; x < around.x + around.width; ++x) {
      const double inside =
          1 - (Vector2d(x + 0.5, y + 0.5) - middle_px).squaredNorm() / (radius * radius);
      if (inside <= 0) continue;
      if (!GetLight(map, x, y, light)) return lens;
      sum += inside * inside * light;
      total += inside * inside;
    }
  }
  if (total > 0) lens.light = sum / total;
  return lens;
}

std::optional<Vector2d> MiddleByShares(const ScreenMap& map, const LensInPhoto& lens,
                                       const std::vector<LensInPhoto>& neighbours) {
  if (neighbours.size() > kMostNeighbours) return std::nullopt;
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (const LensInPhoto& other : neighbours) {
    if (other.light.size() == 0) return std::nullopt;
    const double apart = (other.middle_px - lens.middle_px).norm();
    nearest = std::min(nearest, apart);
    farthest = std::max(farthest, apart);
  }
  if (lens.light.size() == 0 || neighbours.empty() || !(nearest > 0)) return std::nullopt;
  const double reach = std::min(kMostReachPx, kReach * nearest);
  // Hexagons' corners are farther off than their sides.
  const Rect around = PixelsAround(map, lens.middle_px, farthest / std::sqrt(3.0) + reach);
  if (around.width == 0) return std::nullopt;
  const Lenses lenses(lens, neighbours);
  Vector2d sum(0, 0);
  double total = 0;
  std::vector<Eigen::Index> near;
  VectorXd light;
  for (int y = around.y; y < around.y + around.height; ++y) {
    for (int x = around.x; x < around.x + around.width; ++x) {
      const Vector2d at(x + 0.5, y + 0.5);
      lenses.Near(at, reach, near);
      if (near.empty()) continue;
      if (!GetLight(map, x, y, light)) return std::nullopt;
      const double share = lenses.FirstShare(at, light, near);
      sum += share * at;
      total += share;
    }
  }
  if (!(total > 0)) return std::nullopt;
  return Vector2d(sum / total);
}

}  // namespace lamella
