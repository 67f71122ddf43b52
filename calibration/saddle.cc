#include "calibration/saddle.h"

#include <algorithm>
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
// How far a corner's place within a pixel moves it, where blur is about a pixel (same place).
constexpr double kPixelPhasePx = 0.01;

// Sums over the window around a point: M = sum w g g^T, b = sum w g g^T (x - point).
struct SaddleSums {
  Matrix2d m = Matrix2d::Zero();
  Vector2d b = Vector2d::Zero();
};

bool Fits(ImageSpan<const float> image, const Vector2d& point, int half_window) {
  return point.x() - half_window >= 1 && point.y() - half_window >= 1 &&
         point.x() + half_window <= image.width - 1 && point.y() + half_window <= image.height - 1;
}

// Calls visit(x, y, x - point, w, g) for every pixel of the window.
template <class Visit>
void ForWindow(ImageSpan<const float> image, const Vector2d& point, int half_window, Visit visit) {
  const double falloff = 1.0 / (half_window * half_window);
  const auto first = [half_window](double centre) {
    return static_cast<int>(std::ceil(centre - half_window - 0.5));
  };
  for (int y = first(point.y()); y + 0.5 <= point.y() + half_window; ++y) {
    for (int x = first(point.x()); x + 0.5 <= point.x() + half_window; ++x) {
      const Vector2d offset = Vector2d(x + 0.5, y + 0.5) - point;
      const Vector2d g(static_cast<double>(image(x + 1, y) - image(x - 1, y)) / 2,
                       static_cast<double>(image(x, y + 1) - image(x, y - 1)) / 2);
      visit(x, y, offset, std::exp(-falloff * offset.squaredNorm()), g);
    }
  }
}

SaddleSums SumsAround(ImageSpan<const float> image, const Vector2d& point, int half_window) {
  SaddleSums sums;
  ForWindow(image, point, half_window,
            [&](int, int, const Vector2d& offset, double w, const Vector2d& g) {
              sums.m += w * g * g.transpose();
              sums.b += w * g * g.dot(offset);
            });
  return sums;
}

// The covariance of b for white noise of variance 1: how b moves with every pixel. The formula of
// calibration.md section 4 takes gradients for independent, but neighbours share pixels; it is up
// to 1.3 times the standard deviation.
Matrix2d SpreadOfSums(ImageSpan<const float> image, const Vector2d& point, int half_window) {
  const int side = 2 * half_window + 5;
  const int left = static_cast<int>(std::floor(point.x())) - half_window - 2;
  const int top = static_cast<int>(std::floor(point.y())) - half_window - 2;
  std::vector<Vector2d> influence(static_cast<std::size_t>(side * side), Vector2d::Zero());
  const auto at = [&](int x, int y) -> Vector2d& {
    return influence[static_cast<std::size_t>((y - top) * side + x - left)];
  };
  ForWindow(image, point, half_window,
            [&](int x, int y, const Vector2d& offset, double w, const Vector2d& g) {
              const Matrix2d db_dg =
                  w * (g.dot(offset) * Matrix2d::Identity() + g * offset.transpose());
              at(x + 1, y) += db_dg.col(0) / 2;
              at(x - 1, y) -= db_dg.col(0) / 2;
              at(x, y + 1) += db_dg.col(1) / 2;
              at(x, y - 1) -= db_dg.col(1) / 2;
            });
  Matrix2d spread = Matrix2d::Zero();
  for (const Vector2d& moved : influence) spread += moved * moved.transpose();
  return spread;
}

bool HasTwoDirections(const Matrix2d& m) {
  const Vector2d values =
      Eigen::SelfAdjointEigenSolver<Matrix2d>(m, Eigen::EigenvaluesOnly).eigenvalues();  // rising
  return values[1] > 0 && values[0] > kLeastEigenvalueRatio * values[1];
}

}  // namespace

double EstimateNoise(ImageSpan<const float> image) {
  constexpr double kCodeNoise = 1 / (255 * 3.4641016151377544);  // of rounding to 8 bits
  constexpr int kStep = 2;
  std::vector<float> differences;
  for (int y = 1; y + 1 < image.height; y += kStep) {
    for (int x = 1; x + 1 < image.width; x += kStep) {
      const float corners =
          image(x - 1, y - 1) + image(x + 1, y - 1) + image(x - 1, y + 1) + image(x + 1, y + 1);
      const float sides = image(x - 1, y) + image(x + 1, y) + image(x, y - 1) + image(x, y + 1);
      differences.push_back(std::abs(corners - 2 * sides + 4 * image(x, y)));
    }
  }
  if (differences.empty()) return kCodeNoise;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  // The mask's numbers have the square sum 36; the median of |normal| is 0.6745 sigma.
  return std::max(kCodeNoise, static_cast<double>(*middle) / (6 * 0.6745));
}

std::optional<Saddle> RefineSaddle(ImageSpan<const float> image, const Vector2d& start_px,
                                   int half_window, double noise) {
  Vector2d point = start_px;
  for (int i = 0; i < kMostSaddleIterations; ++i) {
    if (!Fits(image, point, half_window)) return std::nullopt;
    const SaddleSums sums = SumsAround(image, point, half_window);
    if (!HasTwoDirections(sums.m)) return std::nullopt;
    const Vector2d step = sums.m.inverse() * sums.b;
    point += step;
    if ((point - start_px).cwiseAbs().maxCoeff() > half_window) return std::nullopt;
    if (step.norm() > kTolerancePx && i + 1 < kMostSaddleIterations) continue;
    const Matrix2d inverse = sums.m.inverse();
    const Matrix2d covariance =
        noise * noise * inverse * SpreadOfSums(image, point, half_window) * inverse;
    return Saddle{point, (covariance + covariance.transpose()) / 2 +
                             kPixelPhasePx * kPixelPhasePx * Matrix2d::Identity()};
  }
  return std::nullopt;
}

}  // namespace lamella
