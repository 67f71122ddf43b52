#include "depth/plane_sweep.h"

#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "depth/shrink.h"
#include "depth/sweep_depth.h"
#include "lightfield/parallel.h"
#include "tests/depth/every_target.h"
#include "tests/depth/synthetic.h"
#include "tests/reference/plane_sweep_reference.h"

namespace lamella {
namespace {

constexpr int kTileColumns = 256, kHalo = 3;  // of depth/plane_sweep.cc: where rows begin

SweepImage RandomSweepImage(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<std::uint8_t> luma(width, height);
  for (std::size_t i = 0; i < luma.size(); ++i)
    luma.data()[i] = static_cast<std::uint8_t>(random());
  return SweepImage(std::move(luma));
}

// A source turned and moved at random; `turn` 0 keeps it parallel.
SweepSource RandomSource(const SweepImage& image, double turn, std::mt19937& random) {
  const auto number = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
  const Camera camera = synthetic::Pinhole(image.width(), image.height(), 0.9 * image.width() + 5);
  Rigid pose;
  pose.rotation =
      Eigen::Quaterniond(1, turn * number(), turn * number(), turn * number()).normalized();
  pose.translation = Eigen::Vector3d(number(), number(), 0.5 * number());
  const PictureMap map = MapPictures(camera, Rigid{}, camera, pose);
  return {&image, map.m, map.b};
}

struct Scenario {
  int width, height, sources;
  double turn;
};

class SweepScenario {
 public:
  explicit SweepScenario(const Scenario& s) : reference(RandomSweepImage(s.width, s.height, 1)) {
    std::mt19937 random(9);
    images.reserve(static_cast<std::size_t>(s.sources));
    for (int i = 0; i < s.sources; ++i) {
      images.push_back(RandomSweepImage(s.width, s.height, 2U + static_cast<unsigned>(i)));
      sources.push_back(RandomSource(images.back(), s.turn, random));
    }
  }
  SweepImage reference;
  std::vector<SweepImage> images;
  std::vector<SweepSource> sources;
  InverseDepthLabels labels{{-0.1, 0, 0.1, 0.25, 0.5, 0.8, 1.5}};
};

const Scenario kScenarios[] = {{40, 37, 1, 0.02}, {40, 37, 2, 0.1},  {33, 70, 3, 0.1},
                               {40, 37, 4, 1.5},  {40, 20, 8, 0.05}, {1, 1, 2, 0},
                               {1, 30, 2, 0.01},  {30, 1, 2, 0.01},  {300, 5, 2, 0.02}};

TEST(SweepCost, EqualsPlainLoopsOnEveryTarget) {
  ForEveryTarget([] {
    for (const Scenario& scenario : kScenarios) {
      const SweepScenario s(scenario);
      const CostVolume cost = SweepCost(s.reference, s.sources, s.labels);
      for (int y = 0; y < scenario.height; y += 1 + scenario.height / 6) {
        for (int x = 0; x < scenario.width; x += 1 + scenario.width / 9) {
          const int x0 = x / kTileColumns * kTileColumns - kHalo;
          for (int d = 0; d < s.labels.count(); ++d) {
            const int expected = reference::SweepCost(
                s.reference, s.sources, s.labels.w[static_cast<std::size_t>(d)], x0, x, y);
            // The scale 8 / (9 half) is rounded to 16 bits.
            ASSERT_NEAR(cost.At(x, y)[d], expected, 1)
                << scenario.width << ": " << x << "," << y << " label " << d;
          }
          for (int d = s.labels.count(); d < cost.stride; ++d)
            ASSERT_EQ(cost.At(x, y)[d], CostVolume::kMaxCost);
        }
      }
    }
  });
}

TEST(SweepCost, IsTheSameOnEveryTargetAndWithEveryNumberOfThreads) {
  const SweepScenario s({300, 70, 4, 0.1});
  const CostVolume expected = SweepCost(s.reference, s.sources, s.labels);
  ForEveryTarget([&] {
    for (const int threads : {1, 2, 3}) {
      const ThreadLimit limit(threads);
      const CostVolume cost = SweepCost(s.reference, s.sources, s.labels);
      ASSERT_TRUE(
          std::equal(cost.costs.get(), cost.costs.get() + cost.Bytes(), expected.costs.get()));
    }
  });
}

TEST(SweepCost, IsLowestAtTheTruePlaneThoughTheExposureChanges) {
  const synthetic::Panel wall{{0, 0, 4}, {1, 0, 0}, {0, 1, 0}, 9, 9, 0.2, 3, true};
  const Camera camera = synthetic::Pinhole(96, 64, 90);
  const Rigid there = synthetic::LookAt({0.6, -0.2, 0.3}, {0.1, 0, 4});
  const SweepImage reference(LumaOf(synthetic::Render({wall}, camera, Rigid{}).image.span()));
  Image<std::uint8_t> darker = LumaOf(synthetic::Render({wall}, camera, there).image.span());
  for (std::size_t i = 0; i < darker.size(); ++i) {
    darker.data()[i] = static_cast<std::uint8_t>(0.7 * darker.data()[i] + 10);
  }
  const SweepImage source(std::move(darker));
  const PictureMap map = MapPictures(camera, Rigid{}, camera, there);
  const InverseDepthLabels labels{{0.10, 0.15, 0.20, 0.25, 0.30, 0.35}};
  const CostVolume cost = SweepCost(reference, {{&source, map.m, map.b}}, labels);
  int lowest = 0, pixels = 0;
  for (int y = 10; y < 54; ++y) {
    for (int x = 20; x < 76; ++x, ++pixels) {
      const std::uint8_t* c = cost.At(x, y);
      lowest += std::min_element(c, c + labels.count()) - c == 3 ? 1 : 0;
    }
  }
  EXPECT_GT(lowest, 0.97 * pixels);
}

}  // namespace
}  // namespace lamella
