// Normal numbers by their index, in any order: noise that no number of threads changes.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "datasets_synthetic/pixel_points.h"

namespace lamella {

// The ziggurat of Marsaglia and Tsang ("The ziggurat method for generating random variables", 2000)
// with 256 layers: 99 in 100 numbers take a hash, a product and a comparison. A layer's number and
// the place in it are of different bits (Doornik 2005), 53 of them for the place.
class NormalNumbers {
 public:
  NormalNumbers();
  // Mean 0, variance 1; numbers of different indices are independent.
  double operator()(std::uint64_t index) const {
    const std::uint64_t hash = MixedHash(index);
    const std::size_t layer = hash % kLayers;
    const double x = PlaceOf(hash) * right_[layer];
    return std::abs(x) < right_[layer + 1] ? x : Beside(hash);
  }

 private:
  static constexpr std::size_t kLayers = 256;
  static double PlaceOf(std::uint64_t hash) {  // in [-1, 1)
    return static_cast<double>(static_cast<std::int64_t>(hash) >> 11) * 0x1p-52;
  }
  // Of a hash whose place is not for certain under the curve.
  double Beside(std::uint64_t hash) const;

  std::array<double, kLayers + 1>
      right_{};  // of each layer; the lowest, 0, as wide as with its tail
  std::array<double, kLayers + 1> height_{};  // of the curve there
};

}  // namespace lamella
