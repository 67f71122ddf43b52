#include "datasets_synthetic/corner_hits.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace lamella {
namespace {

// A hit's numbers, to be weighed together; the last is not used.
using HitNumbers = Eigen::Matrix<double, 6, 1>;

HitNumbers NumbersOf(const SightHit& hit) {
  HitNumbers numbers;
  numbers << hit.modulator, hit.emitter, hit.cosine, 0;
  return numbers;
}

SightHit HitOf(const HitNumbers& numbers) {
  return {numbers.head<2>(), numbers.segment<2>(2), numbers(4)};
}

// a + b t + c t^2 through three values at t = 0, 1/2 and 1.
struct Quadratic {
  HitNumbers a, b, c;
  Quadratic(const HitNumbers& at_0, const HitNumbers& at_half, const HitNumbers& at_1)
      : a(at_0), b(4 * at_half - 3 * at_0 - at_1), c(2 * (at_0 + at_1) - 4 * at_half) {}
  HitNumbers At(double t) const { return a + t * (b + t * c); }
};

// Along x, at a height of 0 to 1 over the rectangle.
class Patch {
 public:
  explicit Patch(const std::array<HitNumbers, 9>& nodes)
      : columns_{Quadratic(nodes[0], nodes[3], nodes[6]), Quadratic(nodes[1], nodes[4], nodes[7]),
                 Quadratic(nodes[2], nodes[5], nodes[8])} {}
  Quadratic AlongX(double y) const {
    return {columns_[0].At(y), columns_[1].At(y), columns_[2].At(y)};
  }

 private:
  std::array<Quadratic, 3> columns_;
};

// Whether the middle of one of `pixels` is far off the straight line between its edges.
bool Bends(const HitNumbers& at_0, const HitNumbers& at_half, const HitNumbers& at_1, int pixels) {
  constexpr double kStraightPx = 1e-3;
  const HitNumbers off = Quadratic(at_0, at_half, at_1).c / (4.0 * pixels * pixels);
  return !(off.head<4>().cwiseAbs().maxCoeff() < kStraightPx);
}

bool AreClose(const SightHit& a, const SightHit& b) {
  constexpr double kClosePx = 1e-4;
  return (a.emitter - b.emitter).norm() < kClosePx && (a.modulator - b.modulator).norm() < kClosePx;
}

}  // namespace

std::optional<CornerHits> CornerHits::Between(const Rect& rectangle, const TraceSight& trace) {
  const auto hit_at = [&](double x, double y) {
    return trace(rectangle.x + x * rectangle.width, rectangle.y + y * rectangle.height);
  };
  std::array<HitNumbers, 9> nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t column = i % 3, row = i / 3;
    const auto hit = hit_at(0.5 * static_cast<double>(column), 0.5 * static_cast<double>(row));
    if (!hit) return std::nullopt;
    nodes[i] = NumbersOf(*hit);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (Bends(nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2], rectangle.width) ||
        Bends(nodes[i], nodes[i + 3], nodes[i + 6], rectangle.height)) {
      return std::nullopt;
    }
  }
  const Patch patch(nodes);
  // A third derivative's error goes as t (t - 1/2) (t - 1). Of x and y it adds up at one of these
  // two places, whatever its signs.
  constexpr double kWorst = 0.2113248654051871;  // 1/2 - sqrt(3)/6
  for (const double y : {kWorst, 1 - kWorst}) {
    const auto hit = hit_at(kWorst, y);
    if (!hit || !AreClose(*hit, HitOf(patch.AlongX(y).At(kWorst)))) return std::nullopt;
  }
  CornerHits corners(rectangle);
  corners.hits_.reserve(static_cast<std::size_t>(rectangle.width + 1) *
                        static_cast<std::size_t>(rectangle.height + 1));
  for (int y = 0; y <= rectangle.height; ++y) {
    const Quadratic row = patch.AlongX(static_cast<double>(y) / rectangle.height);
    for (int x = 0; x <= rectangle.width; ++x) {
      corners.hits_.push_back(HitOf(row.At(static_cast<double>(x) / rectangle.width)));
    }
  }
  return corners;
}

SightHit CornerHits::Within(int x, int y, double place_x, double place_y) const {
  const std::array<const SightHit*, 4> about = About(x, y);
  const std::array<double, 4> weights = {(1 - place_x) * (1 - place_y), place_x * (1 - place_y),
                                         place_x * place_y, (1 - place_x) * place_y};
  SightHit hit{{0, 0}, {0, 0}, 0};
  for (std::size_t i = 0; i < about.size(); ++i) {
    hit.modulator += weights[i] * about[i]->modulator;
    hit.emitter += weights[i] * about[i]->emitter;
    hit.cosine += weights[i] * about[i]->cosine;
  }
  return hit;
}

}  // namespace lamella
