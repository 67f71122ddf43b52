#include "depth/neighbours.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/depth/synthetic.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

// Views on an arc of radius 10 around the origin, `step_deg` apart, looking at it; points on a ball
// of radius 1 there, seen by all. `offset` moves the whole world.
ViewSet Arc(int count, double step_deg, bool points, const Vector3d& offset = Vector3d::Zero()) {
  ViewSet set;
  for (int i = 0; i < count; ++i) {
    const double a = (i - (count - 1) / 2.0) * step_deg * std::numbers::pi / 180;
    View view;
    view.name = std::to_string(i);
    view.camera = synthetic::Pinhole(600, 400, 600);
    view.camera_from_world =
        synthetic::LookAt(offset + Vector3d(10 * std::sin(a), 0, -10 * std::cos(a)), offset);
    set.views.push_back(view);
  }
  for (int i = 0; points && i < 100; ++i) {
    SparsePoint point;
    point.position =
        offset + Vector3d(std::cos(i), std::sin(1.7 * i), std::sin(0.9 * i)).normalized();
    for (int v = 0; v < count; ++v) point.views.push_back(v);
    set.points.push_back(point);
  }
  return set;
}

std::vector<int> ViewsOf(const std::vector<Neighbour>& neighbours) {
  std::vector<int> views;
  for (const Neighbour& n : neighbours) views.push_back(n.view);
  return views;
}

TEST(Neighbourhood, TakesBothSidesByTurns) {
  for (const bool points : {true, false}) {
    const ViewSet set = Arc(7, 10, points);
    const std::vector<int> order = ViewsOf(Neighbourhood(set).Of(3));
    ASSERT_EQ(order.size(), 6U);
    // One of each side at the best angle, then one of each side farther on.
    EXPECT_EQ(std::min(order[0], order[1]), 2);
    EXPECT_EQ(std::max(order[0], order[1]), 4);
    EXPECT_EQ(std::min(order[2], order[3]), 1);
    EXPECT_EQ(std::max(order[2], order[3]), 5);
  }
}

TEST(Neighbourhood, MeasuresTheAngleAtThePoints) {
  const ViewSet set = Arc(2, 12, true);
  const std::vector<Neighbour> neighbours = Neighbourhood(set).Of(0);
  ASSERT_EQ(neighbours.size(), 1U);
  EXPECT_NEAR(neighbours[0].angle_deg, 12, 0.5);
}

TEST(Neighbourhood, DoesNotDependOnWhereTheWorldLies) {
  const ViewSet here = Arc(9, 4, true), far = Arc(9, 4, true, Vector3d(1e7, -3e7, 2e7));
  for (int v = 0; v < 9; ++v) {
    EXPECT_EQ(ViewsOf(Neighbourhood(here).Of(v)), ViewsOf(Neighbourhood(far).Of(v)));
  }
  EXPECT_NEAR(Neighbourhood(here).MeasuredRange(4)->near, Neighbourhood(far).MeasuredRange(4)->near,
              1e-6);
}

TEST(Neighbourhood, RangeIsThatOfTheViewsPointsWithoutTheirTails) {
  ViewSet set = Arc(2, 12, true);
  for (SparsePoint& point : set.points)
    point.position = Vector3d(0, 0, 0.01 * (&point - set.points.data()));
  set.points[0].position =
      set.views[0].camera_from_world.rotation.conjugate() * Vector3d(0, 0, 1e-3) +
      Centre(set.views[0].camera_from_world);  // a wrong point at the lens
  const auto range = Neighbourhood(set).MeasuredRange(0);
  ASSERT_TRUE(range);
  EXPECT_GT(range->near, 9.9);
  EXPECT_LT(range->far, 11.1);
}

TEST(Neighbourhood, LeavesOutViewsThatCarryNoDepth) {
  ViewSet set = Arc(4, 10, true);
  set.views[1].camera_from_world = set.views[0].camera_from_world;  // the same place
  set.views[2].camera_from_world = set.views[0].camera_from_world;
  set.views[2].camera_from_world.translation.x() += 1e-9;
  EXPECT_EQ(ViewsOf(Neighbourhood(set).Of(0)), std::vector<int>{3});
}

TEST(Neighbourhood, IsEmptyForOneViewForViewsBackToBackAndForOneViewTwice) {
  EXPECT_TRUE(Neighbourhood(Arc(1, 10, false)).Of(0).empty());
  ViewSet back_to_back = Arc(2, 10, false);
  back_to_back.views[0].camera_from_world = synthetic::LookAt({0, 0, 0}, {0, 0, 1});
  back_to_back.views[1].camera_from_world = synthetic::LookAt({0, 0, -1}, {0, 0, -2});
  EXPECT_TRUE(Neighbourhood(back_to_back).Of(0).empty());
  ViewSet twice = Arc(2, 10, false);
  twice.views[1] = twice.views[0];
  EXPECT_TRUE(Neighbourhood(twice).Of(0).empty());
}

TEST(ChooseSources, TakesThoseWithinTheAngleAndAtLeastTwo) {
  const std::vector<Neighbour> neighbours = {
      {7, 12, 9}, {3, 30, 8}, {5, 14, 7}, {2, 40, 6}, {1, 10, 5}};
  EXPECT_EQ(ChooseSources(neighbours, 15, 4), (std::vector<int>{7, 5, 1}));
  EXPECT_EQ(ChooseSources(neighbours, 15, 2), (std::vector<int>{7, 5}));
  EXPECT_EQ(ChooseSources(neighbours, 11, 4), (std::vector<int>{1, 7}));
  EXPECT_EQ(ChooseSources(neighbours, 1, 1), (std::vector<int>{7}));
  EXPECT_TRUE(ChooseSources({}, 15, 4).empty());
}

}  // namespace
}  // namespace lamella
