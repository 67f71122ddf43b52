#include "calibration/saddle.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kMostSaddleIterations = 50;
constexpr double kTolerancePx = 1e-3;
// Edges of one direction leave M this ill conditioned.
constexpr double kLeastEigenvalueRatio = 0.02;
// What is not noise, where photographs are blurred by 0.7 px and more.
constexpr double kLeastDeviationPx = 0.002;

// Sums over the window around a point: M = sum w g g^T, b = sum w g g^T (x - point).
struct SaddleSums {
  Matrix2d m = Matrix2d::Zero();
  Vector2d b = Vector2d::Zero();
};

bool Fits(ImageSpan<const float> image, const Vector2d& point, int half_window) {
  return point.x() - half_window >= 1 && point.y() - half_window >= 1 &&
         point.x() + half_window <= image.width - 1 && point.y() + half_window <= image.height - 1;
}

struct WindowPixel {
  int x, y;
  Vector2d offset;  // from the window's point
  Vector2d gradient;
  double weight;
  Vector2d d_weight;  // by the point's movement
};

// Calls visit(pixel) for every pixel of the window. The weight reaches zero at the window's border:
// where it ends in a step instead, pixels that come and go with the corner's place between them
// move it by 0.003 to 0.009 px at a blur of 1 px.
template <class Visit>
void ForWindow(ImageSpan<const float> image, const Vector2d& point, int half_window, Visit visit) {
  const auto weight = [half_window](double offset) {
    const double share = offset / half_window;
    return 1 - share * share;
  };
  const auto first = [half_window](double centre) {
    return static_cast<int>(std::ceil(centre - half_window - 0.5));
  };
  for (int y = first(point.y()); y + 0.5 <= point.y() + half_window; ++y) {
    for (int x = first(point.x()); x + 0.5 <= point.x() + half_window; ++x) {
      const Vector2d offset = Vector2d(x + 0.5, y + 0.5) - point;
      const Vector2d g(static_cast<double>(image(x + 1, y) - image(x - 1, y)) / 2,
                       static_cast<double>(image(x, y + 1) - image(x, y - 1)) / 2);
      const double along_x = weight(offset.x()), along_y = weight(offset.y());
      const Vector2d d_weight(2 * offset.x() * along_y, 2 * offset.y() * along_x);
      visit(
          WindowPixel{x, y, offset, g, along_x * along_y, d_weight / (half_window * half_window)});
    }
  }
}

SaddleSums SumsAround(ImageSpan<const float> image, const Vector2d& point, int half_window) {
  SaddleSums sums;
  ForWindow(image, point, half_window, [&](const WindowPixel& pixel) {
    const Vector2d& g = pixel.gradient;
    sums.m += pixel.weight * g * g.transpose();
    sums.b += pixel.weight * g * g.dot(pixel.offset);
  });
  return sums;
}

// -db/dpoint. That is not M: the window moves along, which counts where it is not much larger than
// the blur (12 % of the standard deviation for 5 px and 1 px).
Matrix2d SlopeOfSums(ImageSpan<const float> image, const Vector2d& point, int half_window) {
  Matrix2d slope = Matrix2d::Zero();
  ForWindow(image, point, half_window, [&](const WindowPixel& pixel) {
    const Vector2d& g = pixel.gradient;
    slope += g * (pixel.weight * g - g.dot(pixel.offset) * pixel.d_weight).transpose();
  });
  return slope;
}

// The covariance of b: how it moves with every pixel, and the noise of that one. The formula of
// calibration.md section 4 takes gradients for independent, but neighbours share pixels; it is up
// to 1.3 times the standard deviation.
Matrix2d SpreadOfSums(ImageSpan<const float> image, const Vector2d& point, int half_window,
                      const NoiseCurve& noise) {
  const int side = 2 * half_window + 5;
  const int left = static_cast<int>(std::floor(point.x())) - half_window - 2;
  const int top = static_cast<int>(std::floor(point.y())) - half_window - 2;
  std::vector<Vector2d> influence(static_cast<std::size_t>(side * side), Vector2d::Zero());
  const auto at = [&](int x, int y) -> Vector2d& {
    return influence[static_cast<std::size_t>((y - top) * side + x - left)];
  };
  ForWindow(image, point, half_window, [&](const WindowPixel& pixel) {
    const Vector2d& g = pixel.gradient;
    const Matrix2d db_dg =
        pixel.weight * (g.dot(pixel.offset) * Matrix2d::Identity() + g * pixel.offset.transpose());
    at(pixel.x + 1, pixel.y) += db_dg.col(0) / 2;
    at(pixel.x - 1, pixel.y) -= db_dg.col(0) / 2;
    at(pixel.x, pixel.y + 1) += db_dg.col(1) / 2;
    at(pixel.x, pixel.y - 1) -= db_dg.col(1) / 2;
  });
  Matrix2d spread = Matrix2d::Zero();
  for (int i = 0; i < side * side; ++i) {
    const Vector2d& moved = influence[static_cast<std::size_t>(i)];
    if (moved.isZero(0)) continue;
    const double variance = noise.VarianceAt(image(left + i % side, top + i / side));
    spread += variance * moved * moved.transpose();
  }
  return spread;
}

Matrix2d CovarianceAt(ImageSpan<const float> image, const Vector2d& point, int half_window,
                      const NoiseCurve& noise) {
  const Matrix2d inverse = SlopeOfSums(image, point, half_window).inverse();
  const Matrix2d covariance =
      inverse * SpreadOfSums(image, point, half_window, noise) * inverse.transpose();
  return (covariance + covariance.transpose()) / 2 +
         kLeastDeviationPx * kLeastDeviationPx * Matrix2d::Identity();
}

bool HasTwoDirections(const Matrix2d& m) {
  const Vector2d values =
      Eigen::SelfAdjointEigenSolver<Matrix2d>(m, Eigen::EigenvaluesOnly).eigenvalues();  // rising
  return values[1] > 0 && values[0] > kLeastEigenvalueRatio * values[1];
}

}  // namespace

std::optional<Saddle> RefineSaddle(ImageSpan<const float> image, const Vector2d& start_px,
                                   int half_window, const NoiseCurve& noise) {
  Vector2d point = start_px;
  for (int i = 0; i < kMostSaddleIterations; ++i) {
    if (!Fits(image, point, half_window)) return std::nullopt;
    const SaddleSums sums = SumsAround(image, point, half_window);
    if (!HasTwoDirections(sums.m)) return std::nullopt;
    const Vector2d step = sums.m.inverse() * sums.b;
    if (step.norm() <= kTolerancePx) {
      return Saddle{point + step, CovarianceAt(image, point, half_window, noise)};
    }
    point += step;
    if ((point - start_px).cwiseAbs().maxCoeff() > half_window) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace lamella
