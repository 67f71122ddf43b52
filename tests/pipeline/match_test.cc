#include "pipeline/poses/match.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/reference/match_reference.h"

namespace lamella {
namespace {

// Like SIFT's: a few large elements, length near 512.
Descriptors RandomDescriptors(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::exponential_distribution<double> element(1.0);
  Descriptors descriptors;
  descriptors.count = count;
  for (int i = 0; i < count; ++i) {
    double row[Descriptors::kLength], squared = 0;
    for (double& e : row) {
      e = element(random);
      squared += e * e;
    }
    for (const double e : row) {
      descriptors.rows.push_back(
          static_cast<std::uint8_t>(std::min(255.0, std::round(512 * e / std::sqrt(squared)))));
    }
  }
  return descriptors;
}

// Every second descriptor of `of`, a little changed, in reverse order, among others.
Descriptors NoisyCopies(const Descriptors& of, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> change(-12, 12);
  Descriptors copies = RandomDescriptors(of.count / 3, seed + 1);
  for (int i = of.count - 1; i >= 0; i -= 2) {
    for (int k = 0; k < Descriptors::kLength; ++k) {
      const int at = i * Descriptors::kLength + k;
      const int old = of.rows[static_cast<std::size_t>(at)];
      copies.rows.push_back(static_cast<std::uint8_t>(std::clamp(old + change(random), 0, 255)));
    }
    ++copies.count;
  }
  return copies;
}

TEST(MatchFeatures, EqualsTheReferenceAtEveryCount) {
  for (int count = 0; count <= 40; ++count) {
    const Descriptors a = RandomDescriptors(count, 7), b = NoisyCopies(a, 11);
    EXPECT_EQ(MatchFeatures(PackedDescriptors(a), PackedDescriptors(b)),
              reference::MatchFeatures(a, b))
        << count;
    EXPECT_EQ(MatchFeatures(PackedDescriptors(b), PackedDescriptors(a)),
              reference::MatchFeatures(b, a))
        << count;
  }
}

TEST(MatchFeatures, EqualsTheReferenceOnManyFeaturesAndFindsTheCopies) {
  const Descriptors a = RandomDescriptors(501, 3), b = NoisyCopies(a, 5);
  const auto matches = MatchFeatures(PackedDescriptors(a), PackedDescriptors(b));
  EXPECT_EQ(matches, reference::MatchFeatures(a, b));
  EXPECT_GT(matches.size(), 240U);
}

TEST(MatchFeatures, EqualsTheReferenceOnExtremeBytes) {
  Descriptors a = RandomDescriptors(33, 1);
  std::fill(a.rows.begin(), a.rows.begin() + 3 * Descriptors::kLength, std::uint8_t{255});
  std::fill(a.rows.begin() + 5 * Descriptors::kLength, a.rows.begin() + 7 * Descriptors::kLength,
            std::uint8_t{0});
  const Descriptors b = NoisyCopies(a, 2);
  EXPECT_EQ(MatchFeatures(PackedDescriptors(a), PackedDescriptors(b)),
            reference::MatchFeatures(a, b));
}

TEST(MatchFeatures, RefusesAFeatureThatFitsTwoOthersEquallyWell) {
  const Descriptors a = RandomDescriptors(4, 9);
  Descriptors b = a;
  b.count = 5;
  b.rows.insert(b.rows.end(), a.rows.begin(), a.rows.begin() + Descriptors::kLength);
  const std::vector<FeatureMatch> expected = {{1, 1}, {2, 2}, {3, 3}};
  EXPECT_EQ(MatchFeatures(PackedDescriptors(a), PackedDescriptors(b)), expected);
}

}  // namespace
}  // namespace lamella
