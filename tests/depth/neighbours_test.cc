#include "depth/neighbours.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lamella {
namespace {

using testing::Contains;
using testing::Not;
using testing::SizeIs;
using testing::UnorderedElementsAre;

// Cameras on an arc around the origin, `step_deg` apart, that look at it from a distance of 10.
ViewSet Arc(int count, double step_deg) {
  ViewSet set;
  for (int i = 0; i < count; ++i) {
    const double angle = (i - count / 2) * step_deg * std::numbers::pi / 180;
    View view;
    view.name = std::to_string(i);
    view.camera.width = 640;
    view.camera.height = 480;
    view.camera.fx = view.camera.fy = 700;
    view.camera.cx = 320;
    view.camera.cy = 240;
    view.camera_from_world.rotation = Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY());
    const Eigen::Vector3d centre(-10 * std::sin(angle), 0, -10 * std::cos(angle));
    view.camera_from_world.rotation =
        Eigen::Quaterniond::FromTwoVectors(-centre, Eigen::Vector3d::UnitZ());
    view.camera_from_world.translation = -(view.camera_from_world.rotation * centre);
    set.views.push_back(view);
  }
  return set;
}

ViewSet WithPoints(ViewSet set, int count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (int i = 0; i < count; ++i) {
    SparsePoint point{{coordinate(random), coordinate(random), coordinate(random)}, {}};
    for (int v = 0; v < static_cast<int>(set.views.size()); ++v) point.views.push_back(v);
    set.points.push_back(point);
  }
  return set;
}

const InverseDepthRange kRange{0.08, 0.12, 32};

TEST(ChooseSources, TakesTheNearestTenDegreesOnBothSides) {
  EXPECT_THAT(ChooseSources(WithPoints(Arc(9, 10), 60), 4, kRange, {2, 15}),
              UnorderedElementsAre(3, 5));
}

TEST(ChooseSources, WorksFromThePosesAloneWhereThereAreNoPoints) {
  EXPECT_THAT(ChooseSources(Arc(9, 10), 4, kRange, {2, 15}), UnorderedElementsAre(3, 5));
}

TEST(ChooseSources, LeavesOutViewsOfTheSamePlace) {
  ViewSet set = Arc(5, 8);
  View twin = set.views[2];
  twin.name = "twin";
  set.views.push_back(twin);
  EXPECT_THAT(ChooseSources(WithPoints(set, 60), 2, kRange, {4, 20}), Not(Contains(5)));
}

TEST(ChooseSources, TakesTwoWideOnesWhereNoneIsNarrow) {
  EXPECT_THAT(ChooseSources(WithPoints(Arc(5, 30), 60), 2, kRange, {4, 15}),
              UnorderedElementsAre(1, 3));
}

TEST(ChooseSources, IsEmptyForOneViewAndForViewsThatLookElsewhere) {
  EXPECT_THAT(ChooseSources(Arc(1, 10), 0, kRange, {4, 15}), SizeIs(0));
  ViewSet set = Arc(2, 10);
  const Eigen::Vector3d centre = Centre(set.views[1].camera_from_world);
  Rigid& back = set.views[1].camera_from_world;
  back.rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()) * back.rotation;
  back.translation = -(back.rotation * centre);
  EXPECT_THAT(ChooseSources(set, 0, kRange, {4, 15}), SizeIs(0));
}

TEST(RangeOfPoints, SpansThePointsWithRoomAtBothEnds) {
  const auto range = RangeOfPoints(WithPoints(Arc(3, 10), 200), 1, 64);
  ASSERT_TRUE(range);
  EXPECT_LT(1 / range->w1, 9.0);
  EXPECT_GT(1 / range->w1, 7.5);
  EXPECT_GT(1 / range->w0, 40.0);
  EXPECT_FALSE(RangeOfPoints(Arc(3, 10), 1, 64));
}

}  // namespace
}  // namespace lamella
