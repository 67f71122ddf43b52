#include "datasets_synthetic/pixel_points.h"

#include <algorithm>

namespace lamella {
namespace {

using Directions = std::array<std::uint32_t, 32>;

// Sobol's recurrence for a primitive polynomial of degree `s` with inner coefficients `a` and
// initial odd numbers m.
Directions Recurrence(unsigned s, unsigned a, const std::vector<std::uint32_t>& m) {
  Directions v{};
  for (unsigned i = 0; i < 32; ++i) {
    if (i < s) {
      v[i] = m[i] << (31 - i);
      continue;
    }
    v[i] = v[i - s] ^ (v[i - s] >> s);
    for (unsigned k = 1; k < s; ++k) v[i] ^= ((a >> (s - 1 - k)) & 1U) * v[i - k];
  }
  return v;
}

std::array<Directions, 4> AllDirections() {
  Directions van_der_corput{};
  for (unsigned i = 0; i < 32; ++i) van_der_corput[i] = std::uint32_t{1} << (31 - i);
  return {van_der_corput, Recurrence(1, 0, {1}), Recurrence(2, 1, {1, 3}),
          Recurrence(3, 1, {1, 3, 1})};
}

}  // namespace

PixelPoints::PixelPoints(int count) : points_(static_cast<std::size_t>(std::max(1, count))) {
  const std::array<Directions, 4> directions = AllDirections();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    for (std::size_t d = 0; d < 4; ++d) {
      std::uint32_t bits = 0;
      for (unsigned b = 0; b < 32; ++b) {
        if ((i >> b & 1U) != 0) bits ^= directions[d][b];
      }
      points_[i][d] = bits;
    }
  }
}

std::array<double, 4> PixelPoints::Point(int i, std::uint64_t hash) const {
  const std::uint64_t other = MixedHash(hash);
  const std::array<std::uint32_t, 4> scramble = {
      static_cast<std::uint32_t>(hash), static_cast<std::uint32_t>(hash >> 32),
      static_cast<std::uint32_t>(other), static_cast<std::uint32_t>(other >> 32)};
  std::array<double, 4> point{};
  for (std::size_t d = 0; d < 4; ++d) {
    const std::uint32_t bits = points_[static_cast<std::size_t>(i)][d] ^ scramble[d];
    point[d] = (bits + 0.5) / 4294967296.0;
  }
  return point;
}

}  // namespace lamella
