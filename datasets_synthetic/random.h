// Random numbers that are the same with every compiler: the standard's distributions differ between
// libraries, its generators don't.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace lamella {

// The finaliser of SplitMix64 (Steele et al., 2014).
inline std::uint64_t Scramble(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}
inline std::uint32_t MixSeeds(std::uint32_t seed, std::uint32_t salt) {
  return static_cast<std::uint32_t>(Scramble((static_cast<std::uint64_t>(seed) << 32U) + salt));
}

// Independent normal numbers one after the other, mean 0, variance 1: the sum of 12 uniform ones
// (Irwin-Hall), which never exceeds 6.
class NormalSequence {
 public:
  explicit NormalSequence(std::uint32_t seed) : generator_(seed) {}
  double operator()() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += Uniform();
    return sum;
  }
  double Uniform() { return generator_() * (1.0 / 4294967296.0); }  // [0, 1)

 private:
  std::mt19937 generator_;
};

// The numbers of one pixel.
class PixelRandom {
 public:
  PixelRandom(std::uint32_t seed, int x, int y)
      : state_(Scramble(
            (static_cast<std::uint64_t>(seed) << 32U) ^
            Scramble((static_cast<std::uint64_t>(y) << 32U) + static_cast<std::uint64_t>(x)))) {}
  double Uniform() {  // [0, 1)
    state_ += 0x9e3779b97f4a7c15U;
    return static_cast<double>(Scramble(state_) >> 11U) * 0x1p-53;
  }
  double Normal() {  // Box and Muller, 1958
    const double radius = std::sqrt(-2 * std::log(1 - Uniform()));
    return radius * std::cos(2 * std::numbers::pi * Uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace lamella
