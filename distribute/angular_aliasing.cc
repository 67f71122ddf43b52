#include "distribute/angular_aliasing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr double kStepInViews = 0.25;
// Depths are of one point where they give it places no farther apart.
constexpr double kSamePlacePx = 0.1;

// How far a point is to the right in b's picture of where a sees it, px.
class Parallax {
 public:
  Parallax(const Eye& a, const Eye& b)
      : step_px_((b.position.x() - a.position.x()) / a.pixel_mm),
        distance_mm_(a.position.z()),
        picture_mm_(a.position.z() - a.plane_mm) {}
  double At(float z) const {
    return step_px_ * (1 - picture_mm_ / (distance_mm_ - static_cast<double>(z)));
  }

 private:
  double step_px_, distance_mm_, picture_mm_;
};

// What b gets wrong of a point at a place in a row; nothing where it does not see it.
std::optional<double> ErrorAt(const SeenAgainstTarget& b, const Parallax& parallax, double place,
                              int y, double shift) {
  const double left = std::floor(place);
  if (!(left >= 0 && left + 1 < b.eye.width)) return std::nullopt;
  double error = 0;
  for (const int i : {0, 1}) {
    const int x = static_cast<int>(left) + i;
    const double weight = i == 0 ? left + 1 - place : place - left;
    if (weight == 0) continue;
    if (!(b.known(x, y) >= 0.5F)) return std::nullopt;
    if (!(std::abs(parallax.At(b.z(x, y)) - shift) <= kSamePlacePx)) return std::nullopt;
    error += weight * static_cast<double>(b.seen(x, y) - b.target(x, y));
  }
  return error;
}

}  // namespace

double AliasingStepMm(const Display& display) {
  double least = std::numeric_limits<double>::infinity();
  for (const Layer& layer : display.layers) {
    least = std::min(least, ViewSpacingMm(display, layer, display.distance_mm(layer)));
  }
  return kStepInViews * least;
}

std::optional<double> AngularAliasing(const SeenAgainstTarget& a, const SeenAgainstTarget& b,
                                      int border_px) {
  const Parallax parallax(a.eye, b.eye);
  double change = 0, light = 0;
  for (int y = border_px; y < a.eye.height - border_px; ++y) {
    for (int x = border_px; x < a.eye.width - border_px; ++x) {
      if (!(a.known(x, y) >= 0.5F)) continue;
      const double shift = parallax.At(a.z(x, y));
      const std::optional<double> moved = ErrorAt(b, parallax, x + shift, y, shift);
      if (!moved) continue;
      const double aim = static_cast<double>(a.target(x, y));
      const double error = static_cast<double>(a.seen(x, y)) - aim;
      change += (*moved - error) * (*moved - error);
      light += aim * aim;
    }
  }
  if (!(light > 0)) return std::nullopt;
  return 10 * std::log10(change / light);
}

}  // namespace lamella
