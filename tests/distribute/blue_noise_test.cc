// Blue noise against a plain Fourier transform and against white noise of another generator.
#include "distribute/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace lamella {
namespace {

using Lattice = LensletArray::Lattice;

// Mean power of a tile's level set (values < level) at frequencies in (0, highest] cycles a column,
// over that of all frequencies but 0. The transform takes the tile as repeating: seams count.
double LowPower(const std::vector<double>& tile, int size, double level, double highest) {
  double low = 0, all = 0;
  int low_count = 0, all_count = 0;
  const double step = 2 * std::numbers::pi / size;
  std::vector<std::complex<double>> rows(tile.size());  // transformed along x
  for (int y = 0; y < size; ++y) {
    for (int u = 0; u < size; ++u) {
      std::complex<double> sum = 0;
      for (int x = 0; x < size; ++x) {
        if (tile[y * size + x] < level) sum += std::polar(1.0, -step * u * x);
      }
      rows[y * size + u] = sum;
    }
  }
  for (int u = 0; u < size; ++u) {
    for (int v = 0; v < size; ++v) {
      if (u == 0 && v == 0) continue;
      std::complex<double> sum = 0;
      for (int y = 0; y < size; ++y) sum += rows[y * size + u] * std::polar(1.0, -step * v * y);
      const double frequency = std::hypot(std::min(u, size - u), std::min(v, size - v)) / size;
      if (frequency <= highest) low += std::norm(sum), ++low_count;
      all += std::norm(sum), ++all_count;
    }
  }
  return low / low_count / (all / all_count);
}

TEST(BlueNoise, HasEveryRankOnce) {
  for (const Lattice lattice : {Lattice::kSquare, Lattice::kHexagonal}) {
    const Image<int> ranks = MakeBlueNoise(32, lattice);
    std::vector<int> sorted(ranks.data(), ranks.data() + ranks.size()), all(32 * 32);
    std::sort(sorted.begin(), sorted.end());
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(sorted, all);
  }
  const Image<float>& noise = BlueNoise(Lattice::kHexagonal);
  EXPECT_GT(*std::min_element(noise.data(), noise.data() + noise.size()), 0);
  EXPECT_LT(*std::max_element(noise.data(), noise.data() + noise.size()), 1);
}

TEST(BlueNoise, HasNextToNothingAtLowFrequencies) {
  const int size = kBlueNoiseSize;
  std::vector<double> white(size * size);
  std::iota(white.begin(), white.end(), 0.5);
  for (double& value : white) value /= size * size;
  std::shuffle(white.begin(), white.end(), std::mt19937(5));
  for (const Lattice lattice : {Lattice::kSquare, Lattice::kHexagonal}) {
    const Image<float>& noise = BlueNoise(lattice);
    const std::vector<double> blue(noise.data(), noise.data() + noise.size());
    for (const double level : {0.0625, 0.25, 0.5, 0.75, 0.9375}) {
      const double low = LowPower(blue, size, level, 0.1);
      EXPECT_LT(low, 0.1) << level;
      EXPECT_GT(LowPower(white, size, level, 0.1), 0.7) << level;
    }
  }
}

TEST(BlueNoise, KeepsItsFirstPointsApart) {
  // n points at their best, a hexagonal packing, are sqrt(2 area / (sqrt(3) n)) apart.
  const double row_pitch = std::numbers::sqrt3 / 2;
  const Image<float>& noise = BlueNoise(Lattice::kHexagonal);
  std::vector<std::pair<double, double>> points;
  for (int y = 0; y < noise.height(); ++y) {
    for (int x = 0; x < noise.width(); ++x) {
      if (noise(x, y) < 0.05F) points.emplace_back(x + (y % 2) * 0.5, y * row_pitch);
    }
  }
  const double width = noise.width(), height = noise.height() * row_pitch;
  const double best = std::sqrt(2 * width * height / (std::numbers::sqrt3 * points.size()));
  double nearest = 1e9;
  for (const auto& a : points) {
    for (const auto& b : points) {
      if (&a == &b) continue;
      nearest = std::min(nearest, std::hypot(std::remainder(a.first - b.first, width),
                                             std::remainder(a.second - b.second, height)));
    }
  }
  EXPECT_GT(nearest, 0.5 * best);  // white noise has points side by side
}

}  // namespace
}  // namespace lamella
