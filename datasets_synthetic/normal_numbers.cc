#include "datasets_synthetic/normal_numbers.h"

#include <cmath>

namespace lamella {
namespace {

constexpr double kTail = 3.6541528853610088;  // where it begins
constexpr double kArea = 0.00492867323399;    // of each of 256 layers, under exp(-x^2 / 2)

double Bell(double x) { return std::exp(-0.5 * x * x); }

double ShareOf(std::uint64_t hash) {  // in (0, 1)
  return (static_cast<double>(hash >> 11) + 0.5) * 0x1p-53;
}

// Beyond kTail, above 0 (Marsaglia 1964).
double InTail(std::uint64_t hash) {
  for (;;) {
    hash = MixedHash(hash);
    const double x = -std::log(ShareOf(hash)) / kTail;
    hash = MixedHash(hash);
    if (-2 * std::log(ShareOf(hash)) > x * x) return kTail + x;
  }
}

}  // namespace

NormalNumbers::NormalNumbers() {
  right_[0] = kArea / Bell(kTail);
  right_[1] = kTail;
  height_[1] = Bell(kTail);
  for (std::size_t i = 2; i < kLayers; ++i) {
    height_[i] = height_[i - 1] + kArea / right_[i - 1];
    right_[i] = std::sqrt(-2 * std::log(height_[i]));
  }
  right_[kLayers] = 0;
  height_[kLayers] = 1;
}

double NormalNumbers::Beside(std::uint64_t hash) const {
  for (;;) {
    const std::size_t layer = hash % kLayers;
    const double x = PlaceOf(hash) * right_[layer];
    if (std::abs(x) < right_[layer + 1]) return x;
    if (layer == 0) return std::copysign(InTail(hash), x);
    const std::uint64_t other = MixedHash(hash);
    const double y = height_[layer] + ShareOf(other) * (height_[layer + 1] - height_[layer]);
    if (y < Bell(x)) return x;
    hash = MixedHash(other);
  }
}

}  // namespace lamella
