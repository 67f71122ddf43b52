#include "depth/consistency.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/depth/synthetic.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 80, kHeight = 60;

// The true maps of a scene from places along x, as rendering (not matching) gives them.
struct Rig {
  Rig(const std::vector<synthetic::Panel>& panels, const std::vector<double>& places)
      : camera(synthetic::Pinhole(kWidth, kHeight, 80)) {
    for (const double x : places) {
      poses.push_back(synthetic::LookAt({x, 0, 0}, {x, 0, 5}));
      const synthetic::Picture picture = synthetic::Render(panels, camera, poses.back());
      InverseDepthMap map{Image<float>(kWidth, kHeight), Image<float>(kWidth, kHeight, 0.8F)};
      for (std::size_t i = 0; i < map.w.size(); ++i) {
        const float z = picture.depth.data()[i];
        map.w.data()[i] = z > 0 ? 1 / z : 0;  // nothing there: infinity
      }
      maps.push_back(std::move(map));
    }
  }
  std::vector<NeighbourMap> NeighboursOf(std::size_t view) const {
    std::vector<NeighbourMap> neighbours;
    for (std::size_t v = 0; v < maps.size(); ++v) {
      if (v == view) continue;
      neighbours.push_back({&maps[v], MapPictures(camera, poses[view], camera, poses[v]),
                            MapPictures(camera, poses[v], camera, poses[view])});
    }
    return neighbours;
  }
  Camera camera;
  std::vector<Rigid> poses;
  std::vector<InverseDepthMap> maps;
};

const synthetic::Panel kWall{{0, 0, 8}, {1, 0, 0}, {0, 1, 0}, 40, 40, 0.3, 1, true};
const synthetic::Panel kCard{{0, 0, 4}, {1, 0, 0}, {0, 1, 0}, 0.6, 0.6, 0.3, 2, true};
const ConsistencyOptions kOptions{
    .tolerance = 0.01, .step = 0.002, .return_px = 2, .agreeing = 2, .min_component = 10};

TEST(MakeConsistent, KeepsWhatIsTrueAndLeavesUnknownWhatOthersDoNotSee) {
  Rig rig({kWall, kCard}, {-0.4, 0, 0.4, 0.8});
  const InverseDepthMap result = MakeConsistent(rig.maps[1], rig.NeighboursOf(1), kOptions);
  int known = 0;
  for (std::size_t i = 0; i < result.w.size(); ++i) {
    if (result.w.data()[i] < 0) continue;
    ++known;
    EXPECT_NEAR(result.w.data()[i], rig.maps[1].w.data()[i], 1e-5);
  }
  EXPECT_GT(known, 0.85 * kWidth * kHeight);
}

TEST(MakeConsistent, PutsAWrongPatchRightFromTheNeighboursMaps) {
  Rig rig({kWall}, {-0.4, 0, 0.4, 0.8});
  const InverseDepthMap truth{rig.maps[1].w.Clone(), rig.maps[1].confidence.Clone()};
  for (int y = 20; y < 40; ++y) {
    for (int x = 30; x < 50; ++x) rig.maps[1].w(x, y) = 0.3F;  // floats before the wall
  }
  const InverseDepthMap result = MakeConsistent(rig.maps[1], rig.NeighboursOf(1), kOptions);
  int right = 0;
  for (int y = 20; y < 40; ++y) {
    for (int x = 30; x < 50; ++x) {
      EXPECT_LT(result.w(x, y), 0.2F);  // never the floating patch
      right += std::abs(result.w(x, y) - truth.w(x, y)) < 1e-4F ? 1 : 0;
    }
  }
  EXPECT_GT(right, 0.9 * 400);
}

TEST(MakeConsistent, LeavesUnknownWhatNoneConfirms) {
  Rig rig({kWall}, {-0.4, 0, 0.4});
  for (std::size_t v = 0; v < 3; ++v) {  // every view dreams up another depth at one place
    for (int y = 20; y < 40; ++y) {
      for (int x = 30; x < 50; ++x) rig.maps[v].w(x, y) = 0.25F + 0.1F * static_cast<float>(v);
    }
  }
  const InverseDepthMap result = MakeConsistent(rig.maps[1], rig.NeighboursOf(1), kOptions);
  for (int y = 25; y < 35; ++y) {
    EXPECT_EQ(result.w(40, y), InverseDepthMap::kUnknown);
    EXPECT_EQ(result.confidence(40, y), 0);
  }
}

TEST(MakeConsistent, KnowsInfinity) {
  Rig rig({}, {-0.4, 0, 0.4, 0.8});
  const InverseDepthMap result = MakeConsistent(rig.maps[1], rig.NeighboursOf(1), kOptions);
  for (std::size_t i = 0; i < result.w.size(); ++i) EXPECT_EQ(result.w.data()[i], 0);
  const DepthMap depth = ToDepth(result);
  EXPECT_TRUE(std::isinf(depth.depth(0, 0)));
}

TEST(MakeConsistent, IsSurerTheMoreViewsConfirm) {
  const Rig two({kWall}, {0, 0.4}), four({kWall}, {0, 0.4, -0.4, 0.2});
  const InverseDepthMap a = MakeConsistent(two.maps[0], two.NeighboursOf(0), kOptions);
  const InverseDepthMap b = MakeConsistent(four.maps[0], four.NeighboursOf(0), kOptions);
  EXPECT_NEAR(a.confidence(40, 30), 0.8 / 3, 1e-5);
  EXPECT_NEAR(b.confidence(40, 30), 0.8, 1e-5);
}

TEST(RemoveSmallComponents, TakesIslandsOfOneSurfaceOnly) {
  InverseDepthMap map{Image<float>(20, 20, 0.1F), Image<float>(20, 20, 1.0F)};
  for (int i = 0; i < 3; ++i) map.w(5 + i, 5) = 0.5F;  // an island of 3
  for (int i = 0; i < 20; ++i) map.w(i, 15) = 0.3F;    // a line of 20
  RemoveSmallComponents(map, 0.01, 10);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(map.w(5 + i, 5), InverseDepthMap::kUnknown);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(map.w(i, 15), 0.3F);
  EXPECT_EQ(map.w(10, 10), 0.1F);
  EXPECT_EQ(map.confidence(6, 5), 0);
}

}  // namespace
}  // namespace lamella
