#include "lightfield/view.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

// A camera array as it is built: parallel, sensors shifted so that `focus` has zero disparity.
std::vector<View> Grid(int rows, int columns, double baseline, double focus, const Rigid& world) {
  std::vector<View> views;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      View view;
      view.name = std::to_string(views.size());
      view.grid = GridPosition{r, c};
      view.camera = {.width = 100, .height = 80, .fx = 120, .fy = 120};
      view.camera.cx = 50 + (c - 1) * 120 * baseline / focus;
      view.camera.cy = 40 + (r - 1) * 120 * baseline / focus;
      const Rigid camera_from_rig{Eigen::Quaterniond::Identity(),
                                  {-c * baseline, -r * baseline, 0}};
      view.camera_from_world = camera_from_rig * world;
      views.push_back(view);
    }
  }
  return views;
}

const Rigid kTilted{Eigen::Quaterniond(0.9, 0.2, -0.3, 0.1).normalized(), {3, -1, 8}};

TEST(FindRegularGrid, GivesTheDisparityThatProjectionShows) {
  const std::vector<View> views = Grid(3, 4, 0.1, 5, kTilted);
  const auto grid = FindRegularGrid(views);
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->inverse_depth_of_zero_disparity, 0.2, 1e-9);
  const double depth = 3.2, d = grid->DisparityFromInverseDepth(1 / depth);
  const Eigen::Vector3d world = Inverse(kTilted) * Eigen::Vector3d(0.4, 0.3, depth);
  const Eigen::Vector2d first = *Project(views[0].camera, views[0].camera_from_world * world);
  for (const View& view : views) {
    const Eigen::Vector2d pixel = *Project(view.camera, view.camera_from_world * world);
    EXPECT_NEAR(pixel.x(), first.x() - d * view.grid->column, 1e-9);
    EXPECT_NEAR(pixel.y(), first.y() - d * view.grid->row, 1e-9);
  }
  EXPECT_NEAR(grid->InverseDepthFromDisparity(d), 1 / depth, 1e-12);
}

TEST(FindRegularGrid, KeepsItsNumbersForASubset) {
  const std::vector<View> views = Grid(3, 4, 0.1, 5, kTilted);
  const auto all = FindRegularGrid(views), some = FindRegularGrid({views[1], views[3], views[11]});
  ASSERT_TRUE(all && some);
  EXPECT_NEAR(some->disparity_per_inverse_depth, all->disparity_per_inverse_depth, 1e-9);
}

TEST(FindRegularGrid, FindsNoneWhereAViewDoesNotFit) {
  const std::vector<View> good = Grid(2, 2, 0.1, 5, kTilted);
  EXPECT_FALSE(FindRegularGrid({good[0]}));
  EXPECT_FALSE(FindRegularGrid({}));
  EXPECT_FALSE(FindRegularGrid({good[0], good[0]}));
  auto views = good;
  views[3].grid.reset();
  EXPECT_FALSE(FindRegularGrid(views));
  views = good;
  views[2].camera_from_world.translation.x() += 0.01;
  EXPECT_FALSE(FindRegularGrid(views));
  views = good;
  views[2].camera_from_world.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitX())) *
      views[2].camera_from_world.rotation;
  EXPECT_FALSE(FindRegularGrid(views));
  views = good;
  views[1].camera.cx += 0.5;
  EXPECT_FALSE(FindRegularGrid(views));
  views = good;
  views[1].camera.width += 2;
  EXPECT_FALSE(FindRegularGrid(views));
}

}  // namespace
}  // namespace lamella
