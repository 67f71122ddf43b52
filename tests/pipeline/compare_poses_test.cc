#include "pipeline/compare_poses.h"

#include <random>

#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

std::vector<View> RandomViews(int count) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    View view;
    view.name = "v" + std::to_string(i);
    view.camera_from_world.rotation =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized();
    view.camera_from_world.translation = {normal(random), normal(random), normal(random)};
    views.push_back(view);
  }
  return views;
}

TEST(ComparePoses, IsZeroForTheSamePosesInAnotherWorld) {
  const std::vector<View> truth = RandomViews(6);
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized();
  std::vector<View> moved = truth;  // x' = 2.5 turn x + t
  for (View& view : moved) {
    const Eigen::Vector3d centre =
        2.5 * (turn * Centre(view.camera_from_world)) + Eigen::Vector3d(4, 5, -6);
    view.camera_from_world.rotation = view.camera_from_world.rotation * turn.conjugate();
    view.camera_from_world.translation = -(view.camera_from_world.rotation * centre);
  }
  const PoseComparison result = ComparePoses(moved, truth);
  EXPECT_LT(result.rmse, 1e-12);
  EXPECT_LT(result.mean_rotation_deg, 1e-5);
  EXPECT_NEAR(result.truth_from_estimate.scale, 1 / 2.5, 1e-12);
}

TEST(ComparePoses, FindsOneCameraThatStandsElsewhere) {
  const std::vector<View> truth = RandomViews(40);
  std::vector<View> estimate = truth;
  estimate[0].camera_from_world.translation += Eigen::Vector3d(0.01, 0, 0);
  const PoseComparison result = ComparePoses(estimate, truth);
  EXPECT_NEAR(result.max, 0.01, 5e-4);
  EXPECT_EQ(result.views[0].name, "v0");
}

TEST(ComparePoses, NeedsThreeCommonNames) {
  std::vector<View> truth = RandomViews(4), estimate = truth;
  estimate[0].name = "x";
  estimate[1].name = "y";
  EXPECT_THROW(ComparePoses(estimate, truth), Error);
}

}  // namespace
}  // namespace lamella
