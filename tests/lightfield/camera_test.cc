#include "lightfield/camera.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Camera> Cameras() {
  const Camera pinhole{.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 322, .cy = 236};
  Camera radial = pinhole;
  radial.model = CameraModel::kBrown;
  radial.distortion = {-0.17, 0.03, 1e-3, -2e-3};
  Camera rational = pinhole;
  rational.model = CameraModel::kBrown;
  rational.distortion = {0.2, -0.05, -1e-3, 5e-4, 0.01, 0.3, 0.02, 0.001};
  Camera fisheye = pinhole;
  fisheye.model = CameraModel::kFisheye;
  fisheye.distortion = {0.05, -0.01, 0.002, -0.0003};
  return {pinhole, radial, rational, fisheye};
}

std::vector<Vector2d> Grid(const Camera& camera) {
  std::vector<Vector2d> pixels;
  for (double y = 0.5; y < camera.height; y += 29.9) {
    for (double x = 0.5; x < camera.width; x += 31.3) pixels.emplace_back(x, y);
  }
  pixels.emplace_back(camera.cx, camera.cy);  // on the axis
  return pixels;
}

// OpenCV's formula, written out once more.
Vector2d BrownByHand(const std::array<double, 8>& k, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = (1 + k[0] * r2 + k[1] * std::pow(r2, 2) + k[4] * std::pow(r2, 3)) /
                        (1 + k[5] * r2 + k[6] * std::pow(r2, 2) + k[7] * std::pow(r2, 3));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

TEST(Project, FollowsTheFormulaOfEachModel) {
  const Vector3d point(0.3, -0.2, 1.5);
  const std::vector<Camera> cameras = Cameras();
  EXPECT_NEAR((*Project(cameras[0], point)).x(), 500 * 0.2 + 322, 1e-12);
  EXPECT_NEAR((*Project(cameras[0], point)).y(), 510 * -0.2 / 1.5 + 236, 1e-12);
  for (const std::size_t i : {1U, 2U}) {
    const Vector2d d = BrownByHand(cameras[i].distortion, 0.2, -0.2 / 1.5);
    EXPECT_NEAR((*Project(cameras[i], point)).x(), 500 * d.x() + 322, 1e-11);
    EXPECT_NEAR((*Project(cameras[i], point)).y(), 510 * d.y() + 236, 1e-11);
  }
  const double r = std::hypot(0.3, 0.2), theta = std::atan(r / 1.5), t2 = theta * theta;
  const auto& k = cameras[3].distortion;
  const double angle = theta + k[0] * std::pow(theta, 3) + k[1] * std::pow(theta, 5) +
                       k[2] * std::pow(theta, 7) + k[3] * std::pow(theta, 9);
  EXPECT_GT(t2, 0);
  EXPECT_NEAR((*Project(cameras[3], point)).x(), 500 * angle * 0.3 / r + 322, 1e-11);
}

TEST(Unproject, IsTheInverseOfProject) {
  for (const Camera& camera : Cameras()) {
    for (const Vector2d& pixel : Grid(camera)) {
      const auto direction = Unproject(camera, pixel);
      ASSERT_TRUE(direction) << pixel.transpose();
      const auto back = Project(camera, 3.7 * *direction);
      ASSERT_TRUE(back);
      EXPECT_LT((*back - pixel).norm(), 1e-8) << pixel.transpose();
    }
  }
}

TEST(Project, HasTheJacobianOfDifferences) {
  constexpr double kStep = 1e-6;
  for (const Camera& camera : Cameras()) {
    for (const Vector2d& pixel : Grid(camera)) {
      const Vector3d point = 2.3 * *Unproject(camera, pixel);
      PixelJacobian jacobian;
      ASSERT_TRUE(Project(camera, point, &jacobian));
      for (int i = 0; i < 3; ++i) {
        const Vector3d step = kStep * Vector3d::Unit(i);
        const Vector2d slope =
            (*Project(camera, point + step) - *Project(camera, point - step)) / (2 * kStep);
        EXPECT_LT((jacobian.point.col(i) - slope).norm(), 2e-6 * (1 + slope.norm()))
            << i << " at " << pixel.transpose();
      }
      for (int i = 0; i < Camera::kNumParameters; ++i) {
        const auto moved = [&](double step) {
          Camera c = camera;
          double* parameters[] = {&c.fx, &c.fy, &c.cx, &c.cy};
          if (i < 4) {
            *parameters[i] += step;
          } else {
            c.distortion[static_cast<std::size_t>(i - 4)] += step;
          }
          return *Project(c, point);
        };
        const Vector2d slope = (moved(kStep) - moved(-kStep)) / (2 * kStep);
        EXPECT_LT((jacobian.parameters.col(i) - slope).norm(), 2e-6 * (1 + slope.norm()))
            << i << " at " << pixel.transpose();
      }
    }
  }
}

TEST(Unproject, HasTheJacobianOfDifferences) {
  constexpr double kStep = 1e-4;
  for (const Camera& camera : Cameras()) {
    for (const Vector2d& pixel : Grid(camera)) {
      Eigen::Matrix<double, 3, 2> jacobian;
      ASSERT_TRUE(Unproject(camera, pixel, &jacobian));
      for (int i = 0; i < 2; ++i) {
        const Vector2d step = kStep * Vector2d::Unit(i);
        const Vector3d slope =
            (*Unproject(camera, pixel + step) - *Unproject(camera, pixel - step)) / (2 * kStep);
        EXPECT_LT((jacobian.col(i) - slope).norm(), 1e-8) << i << " at " << pixel.transpose();
      }
    }
  }
}

TEST(Project, SeesNothingBehindTheCamera) {
  for (const Camera& camera : Cameras()) {
    EXPECT_FALSE(Project(camera, {0, 0, -1}));
    EXPECT_FALSE(Project(camera, {0, 0, 0}));
  }
  EXPECT_FALSE(Project(Cameras()[0], {1, 1, -1e-300}));
  EXPECT_FALSE(Project(Cameras()[0], {1, 1, std::nan("")}));
  EXPECT_TRUE(Project(Cameras()[3], {1, 0, -0.1}));  // a fisheye sees a little backwards
}

TEST(Unproject, RefusesPixelsBeyondTheFoldOfTheDistortion) {
  Camera camera = Cameras()[0];
  camera.model = CameraModel::kBrown;
  camera.distortion = {-0.5};  // r (1 - r^2 / 2) never exceeds 0.544
  EXPECT_TRUE(Unproject(camera, {camera.cx + 0.54 * camera.fx, camera.cy}));
  EXPECT_FALSE(Unproject(camera, {camera.cx + 0.56 * camera.fx, camera.cy}));
}

TEST(Camera, WorksAtExtremeFocalLengths) {
  for (const double f : {1.0, 1e6}) {
    const Camera camera{.width = 1000, .height = 1000, .fx = f, .fy = f, .cx = 500, .cy = 500};
    const auto direction = Unproject(camera, {0.5, 999.5});
    ASSERT_TRUE(direction);
    EXPECT_LT((*Project(camera, *direction * 1e7) - Vector2d(0.5, 999.5)).norm(), 1e-9);
  }
}

TEST(Resized, KeepsEveryDirectionAtItsPlaceInThePicture) {
  for (const Camera& camera : Cameras()) {
    for (const double scale : {0.5, 1.0 / 3, 0.123, 2.0}) {
      const Camera resized = Resized(camera, scale);
      const Vector2d pixel(200.25, 111.5);
      const Vector2d there = *Project(resized, *Unproject(camera, pixel));
      EXPECT_NEAR(there.x() / resized.width, pixel.x() / camera.width, 1e-9);
      EXPECT_NEAR(there.y() / resized.height, pixel.y() / camera.height, 1e-9);
    }
  }
}

}  // namespace
}  // namespace lamella
