#include "depth/sgm.h"

#include <random>

#include <gtest/gtest.h>

#include "lightfield/parallel.h"
#include "tests/depth/every_target.h"
#include "tests/reference/sgm_reference.h"

namespace lamella {
namespace {

CostVolume RandomVolume(int width, int height, int labels, unsigned seed) {
  std::mt19937 random(seed);
  CostVolume cost(width, height, labels);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int best = static_cast<int>(random() % static_cast<unsigned>(labels));
      for (int d = 0; d < cost.stride; ++d) {
        const int noise = static_cast<int>(random() % 60U);
        const int value = d >= labels
                              ? CostVolume::kMaxCost
                              : std::min(CostVolume::kMaxCost, 20 * std::abs(d - best) + noise);
        cost.At(x, y)[d] = static_cast<std::uint8_t>(value);
      }
    }
  }
  return cost;
}

Image<std::uint8_t> RandomGuide(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<std::uint8_t> guide(width, height);
  for (std::size_t i = 0; i < guide.size(); ++i)
    guide.data()[i] = static_cast<std::uint8_t>(random());
  return guide;
}

void ExpectEqualToReference(const CostVolume& cost, const Image<std::uint8_t>& guide,
                            const SgmPenalties& penalties) {
  const LabelMap map = SemiGlobalMatch(cost, guide.span(), penalties);
  const auto sums = reference::SumOfPaths(cost, guide, penalties);
  for (int i = 0; i < cost.width * cost.height; ++i) {
    const auto& s = sums[static_cast<std::size_t>(i)];
    const int winner = static_cast<int>(std::min_element(s.begin(), s.end()) - s.begin());
    double label = winner, uniqueness = 0;
    if (winner > 0 && winner + 1 < cost.labels) {
      const double a = s[static_cast<std::size_t>(winner - 1)],
                   b = s[static_cast<std::size_t>(winner)],
                   c = s[static_cast<std::size_t>(winner) + 1];
      label += (a - c) / (2 * (a + c - 2 * b));
      int second = 1 << 30;
      for (int d = 0; d < cost.labels; ++d) {
        if (std::abs(d - winner) > 2) second = std::min(second, s[static_cast<std::size_t>(d)]);
      }
      if (second < 1 << 30) uniqueness = std::min(1.0, (second - b) / (b + 4));
    }
    const auto at = static_cast<std::size_t>(i);
    ASSERT_NEAR(map.label.data()[at] / static_cast<double>(kSubLabels), label, 0.501 / kSubLabels)
        << i;
    ASSERT_NEAR(map.uniqueness.data()[at] / 255.0, uniqueness, 1.001 / 255) << i;
  }
}

TEST(Sgm, EqualsThePlainFormulaAtEverySizeOnEveryTarget) {
  const int sizes[][3] = {{1, 1, 3},    {1, 40, 7},  {40, 1, 33}, {2, 2, 32},
                          {33, 35, 40}, {70, 9, 96}, {5, 70, 130}};
  ForEveryTarget([&] {
    for (const auto& s : sizes) {
      SCOPED_TRACE(testing::Message() << s[0] << "x" << s[1] << "x" << s[2]);
      const CostVolume cost = RandomVolume(s[0], s[1], s[2], 7);
      const Image<std::uint8_t> guide = RandomGuide(s[0], s[1], 8);
      ExpectEqualToReference(cost, guide, {.p1 = 6, .p2 = 45, .p2_contrast = 0});
      ExpectEqualToReference(cost, guide, {.p1 = 8, .p2 = 64, .p2_contrast = 8});
    }
  });
}

TEST(Sgm, StaysExactWhenAllCostsAreTheLargest) {
  CostVolume cost(9, 9, 40);
  std::fill(cost.costs.get(), cost.costs.get() + cost.Bytes(), std::uint8_t{CostVolume::kMaxCost});
  for (int i = 0; i < 9; ++i) cost.At(i, i)[20] = 0;
  ExpectEqualToReference(cost, Image<std::uint8_t>(9, 9),
                         {.p1 = 60, .p2 = SgmPenalties::kMaxPenalty});
}

TEST(Sgm, IsNotSureOfAnythingWhereAllLabelsCostTheSame) {
  CostVolume cost(8, 8, 20);
  std::fill(cost.costs.get(), cost.costs.get() + cost.Bytes(), std::uint8_t{30});
  const LabelMap map = SemiGlobalMatch(cost, Image<std::uint8_t>(8, 8).span(), {});
  for (std::size_t i = 0; i < map.uniqueness.size(); ++i) EXPECT_EQ(map.uniqueness.data()[i], 0);
}

TEST(Sgm, DoesNotDependOnTheNumberOfThreads) {
  const CostVolume cost = RandomVolume(150, 90, 50, 3);
  const Image<std::uint8_t> guide = RandomGuide(150, 90, 4);
  LabelMap maps[2];
  for (int i = 0; i < 2; ++i) {
    const ThreadLimit limit(i + 1);
    maps[i] = SemiGlobalMatch(cost, guide.span(), {.p1 = 8, .p2 = 64, .p2_contrast = 8});
  }
  for (std::size_t i = 0; i < maps[0].label.size(); ++i) {
    ASSERT_EQ(maps[0].label.data()[i], maps[1].label.data()[i]);
    ASSERT_EQ(maps[0].uniqueness.data()[i], maps[1].uniqueness.data()[i]);
  }
}

}  // namespace
}  // namespace lamella
