// The inner loops of distribute/accumulate.h against plain sums.
#include "distribute/accumulate_kernels.h"

#include <limits>
#include <random>
#include <utility>
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

// One layer or two at a time, hard borders and soft ones, and what no layer takes.
TEST(TakeRow, TakesByTheLayersWeightsAndNothingOfWhatIsUnknown) {
  const std::vector<double> positions = {-10, 0, 10};
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<RaySample> row;
  for (const float z : {-kInf, -7.0F, -5.0F, -4.0F, 0.0F, 4.6F, 5.0F, 6.0F, kInf}) {
    row.push_back({{0.25F, 0.5F, 0.75F}, z, 1, 0.5F});
  }
  row.push_back({{kInf, 0, 0}, 0, 1, 1});
  row.push_back({{1, 1, 1}, 0, 1, 0});
  const int count = static_cast<int>(row.size());
  for (const double border_mm : {0.0, 4.0}) {
    const LayerWeights weights(positions, border_mm);
    for (const auto& [first_layer, layers] : {std::pair(0, 1), {1, 1}, {2, 1}, {0, 2}, {1, 2}}) {
      std::vector<Light> taken(Index(layers * count), Light{9, 9, 9, 9});
      TakeRow(row.data(), count, weights, first_layer, layers, taken.data());
      for (int i = 0; i < layers * count; ++i) {
        const RaySample& sample = row[Index(i % count)];
        const bool known = i % count < count - 2;
        const float scale =
            known ? sample.coverage * weights.Weight(first_layer + i / count, sample.z) : 0;
        const Rgb light = known ? scale * sample.color : Rgb();
        ExpectNear(taken[Index(i)], {light.r, light.g, light.b, known ? sample.coverage : 0});
      }
    }
  }
}

}  // namespace
}  // namespace lamella
