// Camera layouts against what their names promise, worked out here.
#include "datasets_synthetic/cameras.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

CameraLayout LayoutOf(const std::string& name) {
  CameraLayout layout;
  layout.layout = name;
  layout.target = {0.3, -0.2, 1};
  layout.distance = 4;
  layout.height = 0.5;
  return layout;
}

Eigen::Vector2d Seen(const View& view, const Vector3d& world) {
  return *Project(view.camera, view.camera_from_world * world);
}

TEST(Cameras, AnOffAxisGridIsRegularAndItsZeroPlaneHoldsTheTarget) {
  CameraLayout layout = LayoutOf("grid");
  layout.rows = 3;
  layout.columns = 5;
  layout.spacing = 0.1;
  const std::vector<View> views = CamerasOf(layout, 1);
  ASSERT_EQ(views.size(), 15U);
  EXPECT_EQ(views[0].grid, (GridPosition{0, 0}));
  EXPECT_EQ(views[14].grid, (GridPosition{2, 4}));
  EXPECT_GT(Centre(views[0].camera_from_world).y(), Centre(views[14].camera_from_world).y());
  EXPECT_LT(Centre(views[0].camera_from_world).x(), Centre(views[14].camera_from_world).x());
  for (const View& view : views) {
    EXPECT_NEAR((Seen(view, layout.target) - Eigen::Vector2d(480, 360)).norm(), 0, 1e-9);
  }
  const auto grid = FindRegularGrid(views);
  ASSERT_TRUE(grid);
  // The target is as far along the axis as from the middle camera.
  EXPECT_NEAR(1 / grid->inverse_depth_of_zero_disparity, std::hypot(4, 0.5), 1e-9);
  EXPECT_NEAR(grid->disparity_per_inverse_depth, 0.1 * 1.05 * 960, 1e-6);
}

TEST(Cameras, AConvergedGridSeesTheTargetInTheMiddleByTurning) {
  CameraLayout layout = LayoutOf("grid");
  layout.views = 9;
  layout.aim = "converged";
  for (const View& view : CamerasOf(layout, 1)) {
    EXPECT_EQ(view.camera.cx, 480);
    EXPECT_NEAR((Seen(view, layout.target) - Eigen::Vector2d(480, 360)).norm(), 0, 1e-9);
    EXPECT_FALSE(view.grid);
  }
}

TEST(Cameras, AJitteredGridIsOutOfPlaceByItsShareOfTheSpacing) {
  CameraLayout layout = LayoutOf("jittered-grid");
  layout.views = 31 * 31;
  layout.place_jitter = 0.2;
  layout.height = 0;
  const std::vector<View> views = CamerasOf(layout, 3);
  double squares = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double x = (static_cast<double>(i % 31) - 15) * layout.spacing;
    const double off = Centre(views[i].camera_from_world).x() - layout.target.x() - x;
    squares += off * off;
    EXPECT_NEAR((Seen(views[i], layout.target) - Eigen::Vector2d(480, 360)).norm(), 0, 1e-9);
  }
  // 961 draws: 3 standard errors are 7 %.
  EXPECT_NEAR(std::sqrt(squares / 961), 0.2 * layout.spacing, 0.07 * 0.2 * layout.spacing);
}

TEST(Cameras, ALineIsStraightAndEven) {
  CameraLayout layout = LayoutOf("line");
  layout.views = 5;
  const std::vector<View> views = CamerasOf(layout, 1);
  ASSERT_EQ(views.size(), 5U);
  for (std::size_t i = 1; i < 5; ++i) {
    const Vector3d step =
        Centre(views[i].camera_from_world) - Centre(views[i - 1].camera_from_world);
    EXPECT_NEAR((step - Vector3d(layout.spacing, 0, 0)).norm(), 0, 1e-12);
  }
}

TEST(Cameras, AnArcKeepsItsDistanceAndADomeSurrounds) {
  CameraLayout layout = LayoutOf("arc");
  for (const View& view : CamerasOf(layout, 1)) {
    EXPECT_NEAR((Centre(view.camera_from_world) - layout.target).norm(), std::hypot(4, 0.5), 1e-12);
  }
  layout.layout = "dome";
  layout.height = 0;
  layout.angle_deg = 360;  // the whole sphere
  layout.views = 200;
  Vector3d mean = Vector3d::Zero();
  for (const View& view : CamerasOf(layout, 1)) {
    const Vector3d offset = Centre(view.camera_from_world) - layout.target;
    EXPECT_NEAR(offset.norm(), 4, 1e-12);
    mean += offset / 200;
    EXPECT_NEAR((Seen(view, layout.target) - Eigen::Vector2d(480, 360)).norm(), 0, 1e-8);
  }
  EXPECT_LT(mean.norm(), 0.05);
  layout.angle_deg = 60;
  for (const View& view : CamerasOf(layout, 1)) {
    const Vector3d offset = Centre(view.camera_from_world) - layout.target;
    EXPECT_GE(offset.z() / 4, std::cos(std::numbers::pi / 6) - 1e-12);
  }
}

TEST(Cameras, AHandheldWalkDependsOnItsSeedAlone) {
  const CameraLayout layout = LayoutOf("handheld");
  const auto first = [&](std::uint32_t seed) {
    return Vector3d(Centre(CamerasOf(layout, seed)[0].camera_from_world));
  };
  EXPECT_EQ(first(1), first(1));
  EXPECT_NE(first(1), first(2));
}

TEST(Cameras, LooksStraightDown) {
  const Rigid pose = LookAt({1, 5, 2}, {1, 0, 2}, Vector3d::UnitY());
  EXPECT_NEAR((pose * Vector3d(1, 0, 2) - Vector3d(0, 0, 5)).norm(), 0, 1e-12);
}

TEST(Cameras, AGridTakesRowsOrColumnsThatDivideItsViews) {
  CameraLayout layout = LayoutOf("grid");
  layout.views = 12;
  layout.rows = 3;
  EXPECT_EQ(CamerasOf(layout, 1).back().grid, (GridPosition{2, 3}));
  layout.rows = 5;
  EXPECT_THROW(CamerasOf(layout, 1), Error);
  layout.rows = 0;
  EXPECT_THROW(CamerasOf(layout, 1), Error);
}

}  // namespace
}  // namespace lamella
