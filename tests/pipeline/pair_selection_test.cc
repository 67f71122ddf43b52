#include "pipeline/poses/pair_selection.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace lamella {
namespace {

// Images in two groups whose members share their largest features; all small features are alike in
// none.
std::vector<ImageFeatures> TwoGroups(int count) {
  std::mt19937 random(4);
  std::exponential_distribution<double> element(1);
  const auto row = [&] {
    std::vector<double> values(Descriptors::kLength);
    double squared = 0;
    for (double& value : values) {
      value = element(random);
      squared += value * value;
    }
    std::vector<std::uint8_t> bytes;
    for (const double value : values) {
      bytes.push_back(static_cast<std::uint8_t>(std::min(255.0, 512 * value / std::sqrt(squared))));
    }
    return bytes;
  };
  std::vector<std::vector<std::uint8_t>> shared[2];
  for (auto& group : shared) {
    for (int i = 0; i < 20; ++i) group.push_back(row());
  }
  std::vector<ImageFeatures> images(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    ImageFeatures& image = images[static_cast<std::size_t>(i)];
    const auto add = [&](const std::vector<std::uint8_t>& bytes, float size) {
      image.descriptors.rows.insert(image.descriptors.rows.end(), bytes.begin(), bytes.end());
      image.sizes.push_back(size);
      ++image.descriptors.count;
    };
    for (int k = 0; k < 300; ++k) add(row(), 1);
    for (const auto& bytes : shared[i % 2]) add(bytes, 100);
  }
  return images;
}

TEST(SelectPairs, TakesAllPairsOfFewImages) {
  EXPECT_EQ(SelectPairs(TwoGroups(9), SilentProgress()).size(), 36U);
  EXPECT_TRUE(SelectPairs(TwoGroups(1), SilentProgress()).empty());
}

TEST(SelectPairs, TakesOfManyThoseThatShareLargeFeaturesAndNeighbours) {
  const auto pairs = SelectPairs(TwoGroups(60), SilentProgress());
  std::size_t expected = 0;
  for (int i = 0; i < 60; ++i) {
    for (int j = i + 1; j < 60; ++j) {
      const bool taken = std::find(pairs.begin(), pairs.end(), std::pair(i, j)) != pairs.end();
      const bool wanted = (j - i) % 2 == 0 || j - i <= 5;
      EXPECT_EQ(taken, wanted) << i << " " << j;
      expected += wanted;
    }
  }
  EXPECT_EQ(pairs.size(), expected);
}

}  // namespace
}  // namespace lamella
