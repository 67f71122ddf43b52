#include "depth/consistency.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "lightfield/parallel.h"
#include "tests/depth/every_target.h"
#include "tests/depth/synthetic.h"
#include "tests/reference/consistency_reference.h"

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

// Maps of a slanted wall with holes, points at infinity and errors of all sizes, from places
// around it: some see little of each other, and one stands in front of the others.
class NoisyRig {
 public:
  NoisyRig(int width, int height, int views) {
    const Camera camera = synthetic::Pinhole(width, height, 0.8 * std::max(width, height) + 1);
    for (int v = 0; v < views; ++v) {
      poses_.push_back(
          Rigid{Eigen::Quaterniond(1, Number(0.05), Number(0.05), Number(0.3)).normalized(),
                Eigen::Vector3d(Number(0.4), Number(0.4), v == 3 ? -3.5 : Number(0.5))});
      maps.push_back(Map(camera, poses_.back()));
    }
    for (int v = 1; v < views; ++v) {
      const Rigid &own = poses_.front(), &other = poses_[static_cast<std::size_t>(v)];
      neighbours.push_back({&maps[static_cast<std::size_t>(v)],
                            MapPictures(camera, own, camera, other),
                            MapPictures(camera, other, camera, own)});
    }
  }
  std::vector<InverseDepthMap> maps;
  std::vector<NeighbourMap> neighbours;

 private:
  double Number(double most) { return most * (static_cast<double>(random_()) / 2147483648.0 - 1); }
  // The wall is n X = 4 in the world.
  InverseDepthMap Map(const Camera& camera, const Rigid& pose) {
    const Vector3d n = pose.rotation * Vector3d(0.3, 0.1, 1);
    const double distance = 4 + n.dot(pose.translation);
    InverseDepthMap map{Image<float>(camera.width, camera.height),
                        Image<float>(camera.width, camera.height)};
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const double wall = n.dot(*Unproject(camera, {x + 0.5, y + 0.5})) / distance;
        const unsigned kind = random_() % 16;
        const double w = kind == 0   ? -1
                         : kind == 1 ? 0
                         : kind < 5  ? 0.3 + Number(0.3)
                                     : std::max(0.0, wall * (1 + Number(0.01)));
        map.w(x, y) = static_cast<float>(w);
        map.confidence(x, y) = static_cast<float>(0.5 + Number(0.5));
      }
    }
    return map;
  }
  std::mt19937 random_{5};
  std::vector<Rigid> poses_;
};

void ExpectSameBytes(const InverseDepthMap& a, const InverseDepthMap& b) {
  ASSERT_EQ(std::memcmp(a.w.data(), b.w.data(), a.w.size() * sizeof(float)), 0);
  ASSERT_EQ(std::memcmp(a.confidence.data(), b.confidence.data(), a.w.size() * sizeof(float)), 0);
}

TEST(MakeConsistent, EqualsThePlainFormulaAtEverySizeOnEveryTarget) {
  const int sizes[][3] = {{83, 61, 7}, {64, 40, 4}, {40, 33, 2}, {1, 1, 3},
                          {1, 40, 4},  {40, 1, 4},  {2, 2, 5},   {30, 20, 1}};
  ForEveryTarget([&] {
    for (const auto& s : sizes) {
      SCOPED_TRACE(testing::Message() << s[0] << "x" << s[1] << ", " << s[2] << " views");
      const NoisyRig rig(s[0], s[1], s[2]);
      for (const double step : {0.0, 0.004}) {
        const ConsistencyOptions options{
            .tolerance = 0.01, .step = step, .return_px = 1.5, .agreeing = 2, .min_component = 0};
        const InverseDepthMap result = MakeConsistent(rig.maps.front(), rig.neighbours, options);
        ExpectSameBytes(result, reference::VoteOnMap(rig.maps.front(), rig.neighbours, options));
        if (s[0] < 50) continue;
        const float* w = result.w.data();
        const auto known = std::count_if(w, w + result.w.size(), [](float v) { return v >= 0; });
        EXPECT_GT(known, s[0] * s[1] / 4);
        EXPECT_LT(known, s[0] * s[1]);
      }
    }
  });
}

TEST(MakeConsistent, DoesNotDependOnTheNumberOfThreads) {
  const NoisyRig rig(83, 61, 5);
  InverseDepthMap results[2];
  for (int i = 0; i < 2; ++i) {
    const ThreadLimit limit(i + 1);
    results[i] = MakeConsistent(rig.maps.front(), rig.neighbours, kOptions);
  }
  ExpectSameBytes(results[0], results[1]);
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
