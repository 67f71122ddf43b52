#include "calibration/homography.h"

#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace lamella {
namespace {

Eigen::Matrix2Xd Grid(int columns, int rows) {
  Eigen::Matrix2Xd points(2, columns * rows);
  for (int i = 0; i < points.cols(); ++i) {
    const int column = i % columns, row = i / columns;
    points.col(i) << 20.0 * column, 15.0 * row;
  }
  return points;
}

Eigen::Matrix3d Slanted() {
  Eigen::Matrix3d h;
  h << 3, 0.2, 400, -0.1, 2.8, 300, 2e-4, -1e-4, 1;
  return h;
}

Eigen::Matrix2Xd Through(const Eigen::Matrix3d& h, const Eigen::Matrix2Xd& points) {
  return (h * points.colwise().homogeneous()).colwise().hnormalized();
}

TEST(FitHomography, FindsTheTrueOneAmongWrongPoints) {
  const Eigen::Matrix2Xd plane = Grid(12, 8);
  Eigen::Matrix2Xd image = Through(Slanted(), plane);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-80, 80);
  for (Eigen::Index i = 0; i < image.cols(); i += 5) {  // two of five are wrong
    image.col(i) += Eigen::Vector2d(number(random), number(random));
    if (i + 2 < image.cols()) image.col(i + 2) += Eigen::Vector2d(number(random), 90);
  }
  const auto h = FitHomography(plane, image);
  ASSERT_TRUE(h);
  EXPECT_LT((*h / (*h)(2, 2) - Slanted()).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(FitHomography, KnowsWhenPointsDetermineNone) {
  EXPECT_FALSE(FitHomography(Grid(9, 1), Through(Slanted(), Grid(9, 1))));
  EXPECT_FALSE(FitHomography(Grid(3, 1), Grid(3, 1)));
  EXPECT_FALSE(FitHomography(Eigen::Matrix2Xd::Zero(2, 8), Grid(4, 2)));
  EXPECT_FALSE(FitHomography(Eigen::Matrix2Xd(2, 0), Eigen::Matrix2Xd(2, 0)));
}

TEST(PoseOfHomography, IsThePoseThatMadeIt) {
  const Rigid pose{
      Eigen::Quaterniond(Eigen::AngleAxisd(2.9, Eigen::Vector3d(1, 0.2, -0.1).normalized())),
      {30, -20, 900}};
  Eigen::Matrix3d h;
  h << pose.Matrix().col(0), pose.Matrix().col(1), pose.translation;
  for (const double scale : {1.0, -0.3}) {
    const Rigid found = PoseOfHomography(scale * h);
    EXPECT_LT(found.rotation.angularDistance(pose.rotation), 1e-12);
    EXPECT_LT((found.translation - pose.translation).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace lamella
