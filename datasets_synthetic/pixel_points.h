// Low-discrepancy points of a pixel: where its lines of sight pass its area and the lens.
//
// The first dimensions of Sobol's sequence (direction numbers of Joe and Kuo 2008); a power of two
// of them are a (0, m, 2)-net in the first two. Every pixel scrambles their digits by a hash of its
// own (Kollig and Keller 2002), so neighbours' errors are independent and the net stays one.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace lamella {

// A well mixed number of an index (splitmix64, Steele et al. 2014); for seeds of pixels and noise.
constexpr std::uint64_t MixedHash(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15U;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31);
}

class PixelPoints {
 public:
  explicit PixelPoints(int count);
  int count() const { return static_cast<int>(points_.size()); }
  // Point `i` of the pixel that `hash` stands for: 4 numbers in (0, 1).
  std::array<double, 4> Point(int i, std::uint64_t hash) const;

 private:
  std::vector<std::array<std::uint32_t, 4>> points_;
};

}  // namespace lamella
