#include "pipeline/poses/undistort.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/depth/every_target.h"
#include "tests/pipeline/textured_room.h"
#include "tests/reference/undistort_reference.h"

namespace lamella {
namespace {

Camera Lens(std::array<double, 8> distortion, CameraModel model = CameraModel::kBrown) {
  return {.model = model,
          .width = 480,
          .height = 360,
          .fx = 400,
          .fy = 404,
          .cx = 246,
          .cy = 176,
          .distortion = distortion};
}

Image<Rgb> Undistort(const Image<Rgb>& image, const Camera& camera, const Camera& pinhole) {
  Image<Rgb> result(pinhole.width, pinhole.height);
  UndistortRows(image, camera, pinhole, 0, result.span());
  return result;
}

double PsnrInside(const Image<Rgb>& a, const Image<Rgb>& b) {
  double sum = 0;
  int count = 0;
  for (int y = 4; y < a.height() - 4; ++y) {
    for (int x = 4; x < a.width() - 4; ++x, ++count) {
      sum += std::pow(static_cast<double>(a(x, y).g - b(x, y).g), 2);
    }
  }
  return -10 * std::log10(sum / count);
}

TEST(Undistort, GivesWhatThePinholeItselfWouldHaveSeen) {
  const Rigid pose = ArcOfCameras(3)[0];
  for (const Camera& camera : {Lens({-0.2, 0.05, 1e-3, -2e-3}), Lens({0.15}),
                               Lens({0.02, -0.01}, CameraModel::kFisheye)}) {
    const Camera pinhole = UndistortedCamera(camera);
    const Image<Rgb> undistorted = Undistort(PhotographRoom(camera, pose), camera, pinhole);
    EXPECT_GT(PsnrInside(undistorted, PhotographRoom(pinhole, pose)), 38.0);
    // Half a pixel beside it, the pictures do not agree.
    Camera shifted = pinhole;
    shifted.cx += 0.5;
    EXPECT_LT(PsnrInside(undistorted, PhotographRoom(shifted, pose)), 34.0);
  }
}

// A ramp's value says where it was sampled.
TEST(Undistort, SamplesWhereTheLensShowsEveryPixel) {
  for (const double focal : {60.0, 700.0, 9000.0}) {
    Camera camera = Lens({-0.25, 0.1, 1e-3, -2e-3, -0.03});
    camera.fx = camera.fy = focal;
    camera.width = static_cast<int>(focal);
    camera.height = 9;
    camera.cx = 0.53 * focal;
    camera.cy = -0.4 * focal;
    const Camera pinhole = UndistortedCamera(camera);
    Image<Rgb> ramp(camera.width, camera.height);
    for (int y = 0; y < ramp.height(); ++y) {
      for (int x = 0; x < ramp.width(); ++x) ramp(x, y).g = static_cast<float>(x) / 16384;
    }
    const Image<Rgb> undistorted = Undistort(ramp, camera, pinhole);
    for (int x = 2; x < pinhole.width - 2; ++x) {
      const Eigen::Vector3d direction((x + 0.5 - pinhole.cx) / pinhole.fx,
                                      (4.5 - pinhole.cy) / pinhole.fy, 1);
      const auto source = Project(camera, direction);
      ASSERT_TRUE(source);
      if (source->x() < 3 || source->x() > camera.width - 3) continue;
      EXPECT_NEAR(static_cast<double>(undistorted(x, 4).g) * 16384, source->x() - 0.5, 2e-3)
          << focal << " px, column " << x;
    }
  }
}

TEST(Undistort, KeepsAPinholesPictureAsItIs) {
  const Camera camera = Lens({}, CameraModel::kPinhole);
  const Image<Rgb> image = PhotographRoom(camera, ArcOfCameras(2)[1]);
  const Camera same = UndistortedCamera(camera);
  EXPECT_EQ(same.fx, camera.fx);
  const Image<Rgb> undistorted = Undistort(image, camera, same);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      EXPECT_NEAR(undistorted(x, y).r, image(x, y).r, 1e-5);
    }
  }
}

TEST(Undistort, EqualsThePlainFormulaOnEveryTarget) {
  Camera sheared = Lens({0.3, 0.4, 2e-2, 3e-2});
  Camera folded = Lens({-0.9, -0.5});  // has no place for rays far from its axis
  folded.fx = folded.fy = 300;
  Camera wide = Lens({0.05, 0.02}, CameraModel::kFisheye);
  wide.fx = wide.fy = 6000;  // the largest steps between knots
  ForEveryTarget([&] {
    for (const Camera& camera : {sheared, folded, wide}) {
      for (const int width : {1, 4, 61, 128}) {
        Camera lens = camera;
        lens.width = width;
        lens.height = 40;
        lens.cx = 0.4 * width;
        lens.cy = 21;
        Camera pinhole = lens;  // as large as the lens's picture, so that it sees beyond its edge
        pinhole.model = CameraModel::kPinhole;
        pinhole.distortion = {};
        std::mt19937 random(3);
        Image<Rgb> image(width, lens.height);
        const auto number = [&] { return static_cast<float>(random()) / 4294967296.0F; };
        for (std::size_t i = 0; i < image.size(); ++i)
          image.data()[i] = {number(), number(), number()};
        const Image<Rgb> result = Undistort(image, lens, pinhole);
        const Image<Rgb> expected = reference::Undistort(image, lens, pinhole);
        for (std::size_t i = 0; i < result.size(); ++i)
          ASSERT_EQ(result.data()[i], expected.data()[i]) << width << " px wide, pixel " << i;
      }
    }
  });
}

TEST(UndistortedCamera, KeepsSizeAndFocalLengthWhereNoPixelSeesBeyondTheEdge) {
  const Camera pinhole = UndistortedCamera(Lens({-0.2, 0.05}));
  EXPECT_EQ(pinhole.width, 480);
  EXPECT_EQ(pinhole.fx, 400);
  EXPECT_EQ(pinhole.cy, 176);
}

TEST(UndistortedCamera, ZoomsInByJustEnoughOtherwise) {
  for (const Camera& camera : {Lens({0.2}), Lens({0.05, 0.1, 5e-3, 5e-3})}) {
    const Camera pinhole = UndistortedCamera(camera);
    EXPECT_EQ(pinhole.width, 480);
    EXPECT_GT(pinhole.fx, 400);
    double nearest = 1e9;
    for (int i = 0; i <= 1000; ++i) {
      const double x = 480 * i / 1000.0, y = 360 * i / 1000.0;
      for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, 0), Eigen::Vector2d(x, 360),
                                           Eigen::Vector2d(0, y), Eigen::Vector2d(480, y)}) {
        const Eigen::Vector2d s = *Project(camera, *Unproject(pinhole, pixel));
        nearest = std::min({nearest, s.x(), s.y(), 480 - s.x(), 360 - s.y()});
      }
    }
    EXPECT_GT(nearest, -1e-3);
    EXPECT_LT(nearest, 0.1);
  }
}

TEST(UndistortedCamera, CanBeSmallerWithoutAliasing) {
  const Camera camera = Lens({-0.1});
  const Camera small = UndistortedCamera(camera, 120);
  EXPECT_EQ(small.width, 120);
  EXPECT_EQ(small.height, 90);
  EXPECT_NEAR(small.fx, 100, 1e-9);
  Image<Rgb> stripes(480, 360);  // of 1 px: grey from afar
  for (int y = 0; y < 360; ++y) {
    for (int x = 0; x < 480; ++x) stripes(x, y) = x % 2 == 0 ? Rgb{1, 1, 1} : Rgb{};
  }
  const Image<Rgb> grey = Undistort(stripes, camera, small);
  for (int y = 2; y < 88; ++y) {
    for (int x = 2; x < 118; ++x) EXPECT_NEAR(grey(x, y).g, 0.5, 0.03);
  }
}

TEST(UndistortPixel, FollowsTheRay) {
  const Camera camera = Lens({-0.2, 0.05, 1e-3, -2e-3});
  const Camera pinhole = UndistortedCamera(camera);
  const Eigen::Vector3d point(0.3, -0.2, 1.1);
  const auto undistorted = UndistortPixel(camera, pinhole, *Project(camera, point));
  ASSERT_TRUE(undistorted);
  EXPECT_LT((*undistorted - *Project(pinhole, point)).norm(), 1e-9);
}

TEST(Undistort, WorksOnOnePixel) {
  Camera camera = Lens({0.1});
  camera.width = camera.height = 1;
  camera.cx = camera.cy = 0.5;
  const Camera pinhole = UndistortedCamera(camera);
  const Image<Rgb> one = Undistort(Image<Rgb>(1, 1, {0.25F, 0.5F, 1}), camera, pinhole);
  EXPECT_NEAR(one(0, 0).g, 0.5, 1e-6);
}

}  // namespace
}  // namespace lamella
