#include "depth/grid_cost.h"

#include <random>

#include <gtest/gtest.h>

#include "lightfield/parallel.h"
#include "tests/depth/every_target.h"
#include "tests/reference/grid_cost_reference.h"

namespace lamella {
namespace {

Image<Rgb8> RandomImage(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<Rgb8> image(width, height);
  Rgb8 last;
  for (std::size_t i = 0; i < image.size(); ++i) {  // a walk, so that small differences occur too
    const auto step = [&](std::uint8_t v) {
      return static_cast<std::uint8_t>(v + random() % 25U - 12U);
    };
    last = {step(last.r), step(last.g), step(last.b)};
    image.data()[i] = last;
  }
  return image;
}

struct Case {
  int width, height;
  std::vector<std::vector<std::pair<int, int>>> arms;  // (columns, rows) of the sources
  DisparityLabels labels;
  bool color;
};

struct Inputs {
  explicit Inputs(const Case& c) : reference(RandomImage(c.width, c.height, 1)) {
    unsigned seed = 2;
    for (const auto& arm : c.arms) {
      for (std::size_t i = 0; i < arm.size(); ++i)
        images.push_back(RandomImage(c.width, c.height, seed++));
    }
    for (const Image<Rgb8>& image : images) planes.emplace_back(image.span(), c.color);
    std::size_t next = 0;
    for (const auto& arm : c.arms) {
      fast.emplace_back();
      slow.emplace_back();
      for (const auto& [columns, rows] : arm) {
        fast.back().push_back({&planes[next], columns, rows});
        slow.back().push_back({&images[next], columns, rows});
        ++next;
      }
    }
  }
  Image<Rgb8> reference;
  std::vector<Image<Rgb8>> images;
  std::vector<GridImage> planes;
  std::vector<GridArm> fast;
  std::vector<std::vector<reference::GridView>> slow;
};

void ExpectEqualToReference(const Case& c) {
  const Inputs in(c);
  const CostVolume cost = GridCost(GridImage(in.reference.span(), c.color), in.fast, c.labels);
  for (int y = 0; y < c.height; y += 1 + c.height / 9) {
    for (int x = 0; x < c.width; x += 1 + c.width / 13) {
      for (int d = 0; d < c.labels.count; ++d) {
        const double expected =
            reference::GridCost(in.reference, in.slow, c.labels.Disparity(d), c.color, x, y);
        // Rounding down to whole codes, and 1/64 code per filter tap.
        ASSERT_NEAR(cost.At(x, y)[d], std::min(expected, 191.0) - 0.5, 2.5)
            << x << "," << y << " label " << d;
      }
      for (int d = c.labels.count; d < cost.stride; ++d)
        ASSERT_EQ(cost.At(x, y)[d], CostVolume::kMaxCost);
    }
  }
}

const std::vector<Case>& Cases() {
  static const std::vector<Case> cases = {
      {20, 18, {{{-1, 0}, {-2, 0}}, {{0, -1}}, {{1, 0}}, {{0, 1}, {0, 3}}}, {-2.3, 0.7, 7}, true},
      {20, 18, {{{-1, 0}}, {{0, -1}}, {{1, 0}}, {{0, 1}}}, {-1, 0.5, 5}, false},
      {19,
       21,
       {{{-2, 0}}, {{-2, -2}}, {{0, -2}}, {{2, -2}}, {{2, 0}}, {{2, 2}}, {{0, 2}}, {{-2, 2}}},
       {-1.7, 0.35, 9},
       true},
      {19, 21, {{}, {}, {}, {}, {{1, 0}}, {{1, 1}}, {{0, 1}}, {}}, {-1.7, 0.9, 4}, false},
      {1, 1, {{{-1, 0}}, {{0, -1}}, {{1, 0}}, {{0, 1}}}, {-2, 1, 5}, true},
      {1, 30, {{{-1, 0}}, {}, {}, {{0, 1}}}, {-2, 1, 5}, true},
      {530, 3, {{{-1, 0}}, {}, {{1, 0}}, {}}, {-40, 26.3, 4}, true},  // two tiles wide
      {40, 35, {{}, {{0, -1}}, {}, {}}, {-100, 67, 4}, true},         // far outside
  };
  return cases;
}

TEST(GridCost, EqualsTheFormulaInDoublePrecision) {
  for (std::size_t i = 0; i < Cases().size(); ++i) {
    SCOPED_TRACE(i);
    ExpectEqualToReference(Cases()[i]);
  }
}

TEST(GridCost, IsTheSameOnEveryTargetAndWithEveryNumberOfThreads) {
  const Case& c = Cases()[2];
  const Inputs in(c);
  const GridImage reference(in.reference.span(), c.color);
  const CostVolume expected = GridCost(reference, in.fast, c.labels);
  ForEveryTarget([&] {
    for (const int threads : {1, 2, 3}) {
      const ThreadLimit limit(threads);
      const CostVolume cost = GridCost(reference, in.fast, c.labels);
      ASSERT_TRUE(
          std::equal(cost.costs.get(), cost.costs.get() + cost.Bytes(), expected.costs.get()));
    }
  });
}

TEST(GridCost, IsZeroForAViewThatShowsTheSameShifted) {
  const Image<Rgb8> image = RandomImage(40, 30, 5);
  Image<Rgb8> shifted(40, 30);  // a source one step to the right sees everything 2 px to the left
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) shifted(x, y) = image(std::min(x + 2, 39), y);
  }
  const GridImage a(image.span(), true), b(shifted.span(), true);
  const CostVolume cost = GridCost(a, {{}, {}, {{&b, 1, 0}}, {}}, {0, 1, 5});
  for (int y = 3; y < 27; ++y) {
    for (int x = 6; x < 34; ++x) {
      EXPECT_EQ(cost.At(x, y)[2], 0);
      EXPECT_GT(cost.At(x, y)[0], 20);
    }
  }
}

}  // namespace
}  // namespace lamella
