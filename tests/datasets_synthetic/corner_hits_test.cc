#include "datasets_synthetic/corner_hits.h"

#include <cmath>

#include <gtest/gtest.h>

namespace lamella {
namespace {

SightHit HitAt(double x, double y, double bent) {
  SightHit hit;
  hit.modulator = {2 + 0.5 * x - 0.01 * x * y + 1e-3 * y * y, 7 - 0.4 * y};
  hit.emitter = {3 + 0.3 * y, 0.5 * x + bent * std::sin(x)};
  hit.cosine = 0.9 - 1e-4 * x;
  return hit;
}

TEST(CornerHits, FollowWhatTurnsSmoothly) {
  const Rect rectangle{5, 7, 16, 9};
  int traced = 0;
  const auto hits = CornerHits::Between(rectangle, [&](double x, double y) {
    ++traced;
    return std::optional(HitAt(x, y, 0));
  });
  ASSERT_TRUE(hits);
  EXPECT_EQ(traced, 11);
  for (int y = 7; y <= 16; ++y) {
    for (int x = 5; x <= 21; ++x) {
      const SightHit hit = HitAt(x, y, 0);
      EXPECT_LT((hits->At(x, y).modulator - hit.modulator).norm(), 1e-12);
      EXPECT_LT((hits->At(x, y).emitter - hit.emitter).norm(), 1e-12);
      EXPECT_NEAR(hits->At(x, y).cosine, hit.cosine, 1e-12);
    }
  }
  EXPECT_LT((hits->Within(8, 9, 0.25, 0.5).emitter - HitAt(8.25, 9.5, 0).emitter).norm(), 1e-12);
}

// Accepted or not, what is said is within 1e-4 px.
TEST(CornerHits, SayNothingOfWhatBendsOrIsNotMet) {
  const Rect rectangle{0, 0, 16, 16};
  bool accepted = false, refused = false;
  for (double bent = 1e-7; bent < 1; bent *= 2) {
    const auto hits = CornerHits::Between(
        rectangle, [&](double x, double y) { return std::optional(HitAt(x, y, bent)); });
    (hits ? accepted : refused) = true;
    for (int x = 0; hits && x <= 16; ++x) {
      EXPECT_LT((hits->At(x, 3).emitter - HitAt(x, 3, bent).emitter).norm(), 2e-4) << bent;
    }
  }
  EXPECT_TRUE(accepted && refused);
  EXPECT_FALSE(CornerHits::Between(rectangle, [&](double x, double y) {
    return x > 15 && y > 15 ? std::nullopt : std::optional(HitAt(x, y, 0));
  }));
}

}  // namespace
}  // namespace lamella
