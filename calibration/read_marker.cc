#include "calibration/read_marker.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kBorderModules = 4 * (kMarkerSideModules - 1);
constexpr int kMostLightBorder = 2, kMostWrong = 2;
// Undoes part of a blur that is wide for the modules: from a module the mean of its neighbours.
constexpr double kSharpening = 1;

std::optional<double> Bilinear(ImageSpan<const float> image, const Vector2d& at) {
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= image.width || y0 + 1 >= image.height) return std::nullopt;
  const double fx = x - x0, fy = y - y0;
  const auto value = [&](int i, int j) { return static_cast<double>(image(x0 + i, y0 + j)); };
  return (1 - fy) * ((1 - fx) * value(0, 0) + fx * value(1, 0)) +
         fy * ((1 - fx) * value(0, 1) + fx * value(1, 1));
}

// A marker's square in modules, border included, seen in a photograph.
class Modules {
 public:
  Modules(ImageSpan<const float> image, const Quad& quad)
      : image_(image), image_from_square_(HomographyFromUnitSquare(quad)) {}

  // The mean about a module's middle.
  std::optional<double> At(double x, double y) const {
    constexpr double kOff = 0.1;
    double sum = 0;
    for (const Vector2d& off : {Vector2d(0, 0), Vector2d(kOff, kOff), Vector2d(-kOff, kOff),
                                Vector2d(kOff, -kOff), Vector2d(-kOff, -kOff)}) {
      const Vector2d at = (Vector2d(x, y) + off) / kMarkerSideModules;
      const auto value = Bilinear(image_, (image_from_square_ * at.homogeneous()).hnormalized());
      if (!value) return std::nullopt;
      sum += *value / 5;
    }
    return sum;
  }

 private:
  ImageSpan<const float> image_;
  Matrix3d image_from_square_;
};

// The middle between the black border and the white around it; nothing where these do not differ
// enough or the border is not black.
std::optional<double> Threshold(const Modules& modules, double least_contrast) {
  constexpr double kOutside = 1.3;  // modules; the white around is 7/3 wide
  double black = 0, white = 0;
  std::array<double, kBorderModules> border{};
  std::size_t next = 0;
  for (int i = 0; i + 1 < kMarkerSideModules; ++i) {
    const double last = kMarkerSideModules - 0.5, far = kMarkerSideModules + kOutside - 0.5;
    for (const auto& [in, out] :
         {std::pair{Vector2d(i + 0.5, 0.5), Vector2d(i + 0.5, 0.5 - kOutside)},
          std::pair{Vector2d(last, i + 0.5), Vector2d(far, i + 0.5)},
          std::pair{Vector2d(i + 1.5, last), Vector2d(i + 1.5, far)},
          std::pair{Vector2d(0.5, i + 1.5), Vector2d(0.5 - kOutside, i + 1.5)}}) {
      const auto dark = modules.At(in.x(), in.y()), light = modules.At(out.x(), out.y());
      if (!dark || !light) return std::nullopt;
      black += (border[next++] = *dark) / kBorderModules;
      white += *light / kBorderModules;
    }
  }
  if (white - black < least_contrast) return std::nullopt;
  const double middle = (white + black) / 2;
  const auto light_ones =
      std::count_if(border.begin(), border.end(), [&](double value) { return value > middle; });
  return light_ones > kMostLightBorder ? std::nullopt : std::optional(middle);
}

}  // namespace

bool ShowsMarker(ImageSpan<const float> grey, const Quad& corners, int id, double least_contrast) {
  const Modules modules(grey, corners);
  const auto threshold = Threshold(modules, least_contrast);
  if (!threshold) return false;
  std::array<std::array<double, kMarkerSideModules>, kMarkerSideModules> levels{};
  for (int j = 0; j < kMarkerSideModules; ++j) {
    for (int i = 0; i < kMarkerSideModules; ++i) {
      levels[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] =
          modules.At(i + 0.5, j + 0.5).value_or(0);
    }
  }
  MarkerBits read = 0;
  for (std::size_t j = 1; j <= kMarkerModules; ++j) {
    for (std::size_t i = 1; i <= kMarkerModules; ++i) {
      const double around =
          (levels[j][i - 1] + levels[j][i + 1] + levels[j - 1][i] + levels[j + 1][i]) / 4;
      if (levels[j][i] + kSharpening * (levels[j][i] - around) > *threshold) {
        read |= MarkerBits{1} << (i - 1 + kMarkerModules * (j - 1));
      }
    }
  }
  return std::popcount(read ^ BitsOfMarker(id)) <= kMostWrong;
}

// Heckbert 1989: the projective map of a unit square.
Matrix3d HomographyFromUnitSquare(const Quad& q) {
  const Vector2d d1 = q[1] - q[2], d2 = q[3] - q[2], sum = q[0] - q[1] + q[2] - q[3];
  Eigen::Matrix2d d;
  d << d1, d2;
  const Vector2d gh = d.inverse() * sum;
  Matrix3d h;
  h.col(0) << q[1] - q[0] + gh.x() * q[1], gh.x();
  h.col(1) << q[3] - q[0] + gh.y() * q[3], gh.y();
  h.col(2) << q[0], 1;
  return h;
}

}  // namespace lamella
