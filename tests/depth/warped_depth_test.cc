#include "depth/warped_depth.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/depth/synthetic.h"

namespace lamella {
namespace {

constexpr float kSure = 1, kGuessed = 0.1F;

// A card of 1.2 x 0.9 before a slanted wall.
std::vector<synthetic::Panel> CardBeforeWall() {
  const Eigen::Vector3d u = Eigen::Vector3d(1, 0, 0.2).normalized();
  return {{{0, 0, 6}, u, {0, 1, 0}, 40, 40, 0.5, 1, false},
          {{0.1, -0.05, 3}, {1, 0, 0}, {0, 1, 0}, 0.6, 0.45, 0.5, 2, false}};
}

DepthMap TrueDepth(const View& view) {
  DepthMap map;
  map.depth = synthetic::Render(CardBeforeWall(), view.camera, view.camera_from_world).depth;
  map.confidence = Image<float>(map.depth.width(), map.depth.height(), 1.0F);
  return map;
}

bool NearEdge(const Image<float>& depth, int x, int y) {
  float low = depth(x, y), high = low;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, depth.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, depth.width() - 1); ++u) {
      low = std::min(low, depth(u, v));
      high = std::max(high, depth(u, v));
    }
  }
  return high > 1.2F * low;
}

enum class Seen { kYes, kNo, kUnclear };

// Whether `other` sees the point that pixel (x, y) of `view` shows, by the true maps of both.
Seen SeenBy(const View& view, const Image<float>& depth, int x, int y, const View& other,
            const Image<float>& other_depth) {
  const auto ray = Unproject(view.camera, {x + 0.5, y + 0.5});
  const Eigen::Vector3d point =
      other.camera_from_world *
      (Inverse(view.camera_from_world) * (static_cast<double>(depth(x, y)) * *ray));
  const auto pixel = Project(other.camera, point);
  if (!pixel) return Seen::kNo;
  const int u = static_cast<int>(std::floor(pixel->x())),
            v = static_cast<int>(std::floor(pixel->y()));
  if (u < -1 || v < -1 || u > other_depth.width() || v > other_depth.height()) return Seen::kNo;
  if (u < 1 || v < 1 || u >= other_depth.width() - 1 || v >= other_depth.height() - 1) {
    return Seen::kUnclear;
  }
  if (NearEdge(other_depth, u, v)) return Seen::kUnclear;
  return std::abs(static_cast<double>(other_depth(u, v)) - point.z()) < 0.1 ? Seen::kYes
                                                                            : Seen::kNo;
}

// Counts of a warped map's pixels away from edges.
struct Counts {
  int seen = 0, hidden = 0;
};

// Seen pixels have the true depth, hidden ones that of the wall with little confidence.
Counts CheckAgainstTruth(const View& target, const std::vector<View>& given) {
  WarpedDepth warped(target);
  std::vector<DepthMap> maps;
  for (const View& view : given) {
    maps.push_back(TrueDepth(view));
    warped.Add(view, maps.back());
  }
  const DepthMap map = warped.Result();
  const DepthMap truth = TrueDepth(target);
  Counts counts;
  for (int y = 0; y < truth.depth.height(); ++y) {
    for (int x = 0; x < truth.depth.width(); ++x) {
      if (NearEdge(truth.depth, x, y)) continue;
      int yes = 0, no = 0;
      for (std::size_t k = 0; k < given.size(); ++k) {
        const Seen seen = SeenBy(target, truth.depth, x, y, given[k], maps[k].depth);
        yes += seen == Seen::kYes;
        no += seen == Seen::kNo;
      }
      if (yes > 0) {
        ++counts.seen;
        EXPECT_NEAR(map.depth(x, y), truth.depth(x, y), 4e-3F * truth.depth(x, y)) << x << " " << y;
        EXPECT_EQ(map.confidence(x, y), kSure);
      } else if (no == static_cast<int>(given.size())) {
        ++counts.hidden;
        EXPECT_GT(map.depth(x, y), 4.5F) << x << " " << y;
        EXPECT_EQ(map.confidence(x, y), kGuessed) << x << " " << y;
      }
    }
  }
  return counts;
}

TEST(WarpedDepth, OfAGridIsTheTruthWhereTheCentreViewSeesAndTheWallElsewhere) {
  const std::vector<View> grid = synthetic::MakeGrid(3, 3, 96, 100, 0.25, 4.5);
  int hidden = 0;
  for (const int target : {0, 1, 2, 3, 5, 6, 7, 8}) {
    const Counts counts = CheckAgainstTruth(grid[static_cast<std::size_t>(target)], {grid[4]});
    EXPECT_GT(counts.seen, 7500);
    hidden += counts.hidden;
  }
  EXPECT_GT(hidden, 500);
}

TEST(WarpedDepth, OfAPhotographComesFromAllThatSeeIt) {
  const auto photograph = [](const Eigen::Vector3d& centre, int width, double focal) {
    View view;
    view.camera = synthetic::Pinhole(width, 90, focal);
    view.camera_from_world = synthetic::LookAt(centre, {0, 0, 4});
    return view;
  };
  const View target = photograph({0, 0, 0.2}, 100, 90);
  const View left = photograph({-0.8, 0.1, 0}, 140, 100),
             right = photograph({0.7, -0.2, 0}, 120, 80);
  const Counts one = CheckAgainstTruth(target, {left}),
               both = CheckAgainstTruth(target, {left, right});
  EXPECT_GT(one.hidden, 100);
  EXPECT_LT(both.hidden, one.hidden / 4);
  EXPECT_GT(both.seen, one.seen);
}

TEST(WarpedDepth, KeepsInfinityAndKnowsNothingWithoutAView) {
  const std::vector<View> grid = synthetic::MakeGrid(1, 2, 16, 20, 0.1, 4);
  WarpedDepth warped(grid[0]);
  const DepthMap nothing = warped.Result();
  EXPECT_TRUE(std::all_of(nothing.depth.data(), nothing.depth.data() + nothing.depth.size(),
                          [](float z) { return z == 0; }));
  EXPECT_EQ(nothing.confidence(3, 3), 0);
  const Image<float> sky(16, 16, std::numeric_limits<float>::infinity());
  warped.Add(grid[1], {sky.Clone(), Image<float>(16, 16, 1.0F)});
  EXPECT_TRUE(std::isinf(warped.Result().depth(8, 8)));
}

TEST(WarpedDepth, FromOnePlaceIsTheSameMap) {
  const View view = synthetic::MakeGrid(1, 1, 32, 40, 0.1, 4)[0];
  const DepthMap truth = TrueDepth(view);
  WarpedDepth warped(view);
  warped.Add(view, truth);
  const DepthMap map = warped.Result();
  for (std::size_t i = 0; i < truth.depth.size(); ++i) {
    EXPECT_NEAR(map.depth.data()[i], truth.depth.data()[i], 1e-5F * truth.depth.data()[i]);
  }
}

TEST(NearestViews, AreOrderedByDistance) {
  const std::vector<View> grid = synthetic::MakeGrid(1, 5, 8, 10, 0.1, 4);
  EXPECT_EQ(NearestViews(grid, 1, {0, 3, 4}, 5), (std::vector<int>{0, 3, 4}));
  EXPECT_EQ(NearestViews(grid, 4, {0, 2, 3}, 2), (std::vector<int>{3, 2}));
}

}  // namespace
}  // namespace lamella
