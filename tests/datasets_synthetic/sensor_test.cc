#include "datasets_synthetic/sensor.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/normal_numbers.h"
#include "datasets_synthetic/pixel_points.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

struct SensorMoments {
  double mean = 0, variance = 0;
};

SensorMoments SensorMomentsOf(const Image<Rgb>& image) {
  double sum = 0, squares = 0;
  const double n = 3 * static_cast<double>(image.size());
  for (std::size_t i = 0; i < image.size(); ++i) {
    for (const float value : {image.data()[i].r, image.data()[i].g, image.data()[i].b}) {
      sum += static_cast<double>(value);
      squares += static_cast<double>(value) * static_cast<double>(value);
    }
  }
  return {sum / n, squares / n - sum / n * sum / n};
}

TEST(Sensor, HasTheVarianceOfShotAndReadNoise) {
  const Image<Rgb> light(300, 200, Rgb{0.2F, 0.2F, 0.2F});
  Sensor sensor;
  sensor.exposure = 2;
  sensor.full_well_e = 5000;
  sensor.read_noise_e = 20;
  const SensorMoments moments = SensorMomentsOf(Develop(light.span(), sensor, 7));
  const double variance = (0.4 * 5000 + 400) / (5000.0 * 5000);
  const double n = 180000;
  EXPECT_NEAR(moments.mean, 0.4, 5 * std::sqrt(variance / n));
  EXPECT_NEAR(moments.variance / variance, 1, 5 * std::sqrt(2 / n));
}

TEST(Sensor, RepeatsItselfForASeedOnly) {
  const Image<Rgb> light(20, 10, Rgb{0.2F, 0.2F, 0.2F});
  Sensor sensor;
  sensor.full_well_e = 1000;
  const Image<Rgb> a = Develop(light.span(), sensor, 1), b = Develop(light.span(), sensor, 1),
                   c = Develop(light.span(), sensor, 2);
  int same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.data()[i], b.data()[i]);
    same += a.data()[i] == c.data()[i];
  }
  EXPECT_LT(same, 5);
}

TEST(Sensor, EncodesAndRoundsToItsBits) {
  Image<Rgb> light(1, 1, Rgb{0.2F, 3, 0.0001F});
  Sensor sensor;
  sensor.bits = 10;
  sensor.curve = Sensor::Curve::kGamma;
  sensor.gamma = 2;
  sensor.pedestal = 0.01;
  const Image<Rgb> numbers = Develop(light.span(), sensor, 0);
  EXPECT_NEAR(numbers(0, 0).r, std::round(std::sqrt(0.21) * 1023) / 1023, 1e-7);
  EXPECT_EQ(numbers(0, 0).g, 1);
  EXPECT_NEAR(numbers(0, 0).b, std::round(std::sqrt(0.0101) * 1023) / 1023, 1e-7);
  sensor.curve = Sensor::Curve::kSrgb;
  sensor.bits = 8;
  sensor.pedestal = 0;
  // 0.2 linear is 123.6 in sRGB codes of 8 bits (IEC 61966-2-1).
  EXPECT_NEAR(Develop(light.span(), sensor, 0)(0, 0).r * 255, 124, 1e-4);
  sensor.bits = 7;
  EXPECT_THROW(Develop(light.span(), sensor, 0), Error);
  sensor.bits = 8;
  sensor.exposure = 0;
  EXPECT_THROW(Develop(light.span(), sensor, 0), Error);
}

// Kolmogorov's distance of a million numbers from the normal distribution, and what is beyond 4,
// where every layer of the ziggurat is left behind.
TEST(NormalNumbers, AreNormal) {
  const NormalNumbers normal;
  constexpr int kCount = 1000000;
  std::vector<double> numbers;
  for (int i = 0; i < kCount; ++i) {
    numbers.push_back(normal(MixedHash(5) + static_cast<std::uint64_t>(i)));
  }
  double lag = 0;
  for (int i = 1; i < kCount; ++i) {
    lag += numbers[static_cast<std::size_t>(i)] * numbers[static_cast<std::size_t>(i - 1)];
  }
  EXPECT_LT(std::abs(lag / kCount), 4 / std::sqrt(kCount));
  std::sort(numbers.begin(), numbers.end());
  const auto share_below = [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); };
  double distance = 0;
  for (int i = 0; i < kCount; ++i) {
    const double below = share_below(numbers[static_cast<std::size_t>(i)]);
    distance = std::max(distance, std::abs(below - (i + 0.5) / kCount));
  }
  EXPECT_LT(distance, 1.95 / std::sqrt(kCount));  // once in a thousand it is more
  const double far = 2 * kCount * share_below(-4);
  const auto beyond =
      std::count_if(numbers.begin(), numbers.end(), [](double x) { return std::abs(x) > 4; });
  EXPECT_NEAR(static_cast<double>(beyond), far, 4 * std::sqrt(far));
  EXPECT_GT(numbers.back(), 4.2);
  EXPECT_LT(numbers.front(), -4.2);
}

// A net: of 64 points one falls into each box of 1/64 of the area, whatever the pixel's scrambling.
TEST(PixelPoints, AreANetInEveryPixel) {
  const PixelPoints points(64);
  for (const std::uint64_t hash : {MixedHash(1), MixedHash(99)}) {
    for (const int columns : {1, 2, 4, 8, 16, 32, 64}) {
      std::set<int> boxes;
      for (int i = 0; i < 64; ++i) {
        const auto p = points.Point(i, hash);
        const int rows = 64 / columns;
        boxes.insert(static_cast<int>(p[0] * columns) * rows + static_cast<int>(p[1] * rows));
      }
      EXPECT_EQ(boxes.size(), 64U) << columns;
    }
    for (std::size_t d = 0; d < 4; ++d) {
      std::set<int> slices;
      for (int i = 0; i < 64; ++i) slices.insert(static_cast<int>(points.Point(i, hash)[d] * 64));
      EXPECT_EQ(slices.size(), 64U) << d;
    }
  }
}

}  // namespace
}  // namespace lamella
