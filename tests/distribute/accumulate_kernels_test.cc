// The inner loops of distribute/accumulate.h against plain sums.
#include "distribute/accumulate_kernels.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace lamella {
namespace {

std::vector<Light> RandomLights(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> value(0, 1);
  std::vector<Light> lights(count);
  for (Light& light : lights) {
    for (float* channel : {&light.r, &light.g, &light.b, &light.coverage}) *channel = value(random);
  }
  return lights;
}

void ExpectNear(const Light& light, const Light& expected) {
  EXPECT_NEAR(light.r, expected.r, 1e-5);
  EXPECT_NEAR(light.g, expected.g, 1e-5);
  EXPECT_NEAR(light.b, expected.b, 1e-5);
  EXPECT_NEAR(light.coverage, expected.coverage, 1e-5);
}

void Add(float weight, const Light& light, Light& sum) {
  sum.r += weight * light.r;
  sum.g += weight * light.g;
  sum.b += weight * light.b;
  sum.coverage += weight * light.coverage;
}

// As many taps as one loop is made for, and more; the last sum's reach to the row's end.
TEST(AddFiltered, AddsWhatEachTakesOfTheRow) {
  std::mt19937 random(1);
  constexpr int kWidth = 40;
  for (int taps = 1; taps <= 7; ++taps) {
    const std::vector<Light> row = RandomLights(kWidth, random);
    const std::vector<int> firsts{0, 11, 12, 3, kWidth - taps};
    std::vector<float> weights;
    for (std::size_t i = 0; i < firsts.size() * static_cast<std::size_t>(taps); ++i) {
      weights.push_back(std::uniform_real_distribution<float>(0, 1)(random));
    }
    std::vector<Light> sums = RandomLights(firsts.size(), random), expected = sums;
    AddFiltered(row.data(), firsts, weights.data(), taps, sums.data());
    for (std::size_t i = 0; i < firsts.size(); ++i) {
      for (int t = 0; t < taps; ++t) {
        Add(weights[i * static_cast<std::size_t>(taps) + static_cast<std::size_t>(t)],
            row.data()[firsts[i] + t], expected[i]);
      }
      ExpectNear(sums[i], expected[i]);
    }
  }
}

// Counts that fill no vector, too.
TEST(AddRows, AddsRowsByTheirWeights) {
  std::mt19937 random(2);
  for (const int count : {1, 3, 4, 17}) {
    const auto width = static_cast<std::size_t>(count);
    const std::vector<Light> a = RandomLights(width, random), b = RandomLights(width, random);
    std::vector<Light> sums = RandomLights(width, random), expected = sums;
    const Light* const rows[] = {a.data(), b.data()};
    const float weights[] = {0.25F, 0.5F};
    AddRows(rows, weights, 2, count, sums.data());
    for (std::size_t x = 0; x < width; ++x) {
      Add(weights[0], a[x], expected[x]);
      Add(weights[1], b[x], expected[x]);
      ExpectNear(sums[x], expected[x]);
    }
  }
}

}  // namespace
}  // namespace lamella
