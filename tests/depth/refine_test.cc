#include "depth/refine.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/depth/every_target.h"
#include "tests/reference/median_reference.h"

namespace lamella {
namespace {

TEST(WeightedMedian, EqualsSortingAtEverySizeOnEveryTarget) {
  const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {33, 17}, {300, 5}};
  ForEveryTarget([&] {
    for (const auto& size : sizes) {
      std::mt19937 random(5);
      Image<SubLabel> labels(size[0], size[1]);
      Image<Rgb8> guide(size[0], size[1]);
      for (std::size_t i = 0; i < labels.size(); ++i) {
        labels.data()[i] = random() % 9 == 0 ? kNoLabel : static_cast<SubLabel>(random() % 65000U);
        const auto code = [&] { return static_cast<std::uint8_t>(random() % 40U); };
        guide.data()[i] = {code(), code(), code()};
      }
      for (const int radius : {0, 2, 3, kMaxMedianRadius}) {
        const Image<SubLabel> median = WeightedMedian(labels.span(), guide.span(), radius);
        for (int y = 0; y < size[1]; ++y) {
          for (int x = 0; x < size[0]; ++x) {
            ASSERT_EQ(median(x, y), reference::WeightedMedianAt(labels, guide, radius, x, y))
                << x << "," << y << " radius " << radius;
          }
        }
      }
    }
  });
}

TEST(WeightedMedian, SnapsToAnEdgeOfColour) {
  Image<SubLabel> labels(20, 20, SubLabel{100});
  Image<Rgb8> guide(20, 20, Rgb8{200, 200, 200});
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      if (x < 10) guide(x, y) = {20, 20, 20};
      if (x < 11) labels(x, y) = 900;  // one column too far
    }
  }
  const Image<SubLabel> median = WeightedMedian(labels.span(), guide.span(), 3);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) EXPECT_EQ(median(x, y), x < 10 ? 900 : 100);
  }
}

}  // namespace
}  // namespace lamella
