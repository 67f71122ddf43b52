// Every degradation against the closed form of what it does.
#include "datasets_synthetic/degrade.h"

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "datasets_synthetic/photograph.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "tests/depth/synthetic.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

Surface Plane(const Vector3d& corner, const Vector3d& u, const Vector3d& v, float light) {
  Texture texture;
  texture.pattern = Texture::Pattern::kPlain;
  texture.light = {light, light, light};
  return {Parallelogram{corner, u, v}, texture, {}};
}

// What is seen is the reflectance itself.
Scene Evenly(std::vector<Surface> surfaces) {
  Scene scene;
  scene.surfaces = std::move(surfaces);
  scene.lighting.lamp_strength = 0;
  scene.lighting.ambient = 1;
  return scene;
}

// Black to the left of the axis and white to the right, at depth z.
Scene EdgeAt(double z) {
  return Evenly({Plane({-90, -50, z}, {90, 0, 0}, {0, 100, 0}, 0),
                 Plane({0, -50, z}, {90, 0, 0}, {0, 100, 0}, 1)});
}

struct Moments {
  double mean = 0, variance = 0, third = 0;
};

Moments MomentsOf(const Image<Rgb>& image) {
  Moments m;
  const double n = 3.0 * static_cast<double>(image.size());
  const auto each = [&](const auto& add) {
    for (std::size_t i = 0; i < image.size(); ++i) {
      const Rgb& c = image.data()[i];
      for (const float v : {c.r, c.g, c.b}) add(static_cast<double>(v));
    }
  };
  each([&](double v) { m.mean += v / n; });
  each([&](double v) { m.variance += (v - m.mean) * (v - m.mean) / n; });
  each([&](double v) { m.third += std::pow(v - m.mean, 3) / n; });
  return m;
}

Image<Rgb> Noisy(float value, double full_well, double read_noise, std::uint32_t seed = 1) {
  Degradation degradation;
  degradation.full_well_e = full_well;
  degradation.read_noise_e = read_noise;
  Exposure exposure;
  exposure.seed = seed;
  Image<Rgb> image(400, 400, {value, value, value});
  Degrade(degradation, exposure, synthetic::Pinhole(400, 400, 400), image);
  return image;
}

// Photons are counted: variance = mean, in electrons; read noise adds its own.
TEST(Degrade, NoiseHasThePoissonVarianceAndThatOfReading) {
  for (const float value : {0.004F, 0.03F, 0.049F, 0.051F, 0.4F}) {  // 4 to 400 electrons
    const Moments m = MomentsOf(Noisy(value, 1000, 6));
    const double electrons = 1000 * static_cast<double>(value);
    EXPECT_NEAR(1000 * m.mean, electrons, 4 * std::sqrt((electrons + 36) / 480000)) << value;
    EXPECT_NEAR(1e6 * m.variance, electrons + 36, 0.01 * (electrons + 36)) << value;
  }
}

TEST(Degrade, FewPhotonsFollowPoissonsLaw) {
  const Image<Rgb> image = Noisy(0.002F, 1000, 0);
  int none = 0;
  for (std::size_t i = 0; i < image.size(); ++i) none += image.data()[i].g == 0 ? 1 : 0;
  const double expected = std::exp(-2.0), n = static_cast<double>(image.size());
  EXPECT_NEAR(none / n, expected, 4 * std::sqrt(expected * (1 - expected) / n));
  // The third central moment is the mean, too: also where the count is a corrected normal number.
  EXPECT_NEAR(1e9 * MomentsOf(Noisy(0.06F, 1000, 0)).third, 60, 8);
}

TEST(Degrade, ASensorHoldsNoMoreThanItsFullWell) {
  EXPECT_FLOAT_EQ(Noisy(3, 1000, 5)(7, 7).g, 1);
  const Image<Rgb> bright = Noisy(1e8F, 1000, 5);
  for (std::size_t i = 0; i < bright.size(); ++i) EXPECT_EQ(bright.data()[i].r, 1);
}

TEST(Degrade, NoiseIsAnotherOneForAnotherSeed) {
  EXPECT_FALSE(Noisy(0.5F, 1000, 0, 1)(3, 4) == Noisy(0.5F, 1000, 0, 2)(3, 4));
  EXPECT_TRUE(Noisy(0.5F, 1000, 0, 1)(3, 4) == Noisy(0.5F, 1000, 0, 1)(3, 4));
}

TEST(Degrade, VignettingFallsWithTheFourthPowerOfTheCosine) {
  Degradation degradation;
  degradation.vignetting = 0.8;
  const Camera camera = synthetic::Pinhole(90, 60, 50);
  Image<Rgb> image(90, 60, {1, 1, 1});
  Degrade(degradation, {}, camera, image);
  for (const auto& [x, y] : {std::pair{0, 0}, {45, 30}, {89, 59}, {70, 5}}) {
    const double tx = (x + 0.5 - 45) / 50, ty = (y + 0.5 - 30) / 50;
    const double fall = 1 / std::pow(1 + tx * tx + ty * ty, 2);
    EXPECT_NEAR(static_cast<double>(image(x, y).g), 0.2 + 0.8 * fall, 1e-6);
  }
}

// A point is a disk, an edge the disk's integral: 1/2 + (asin u + u sqrt(1 - u^2)) / pi.
TEST(Shutter, ALensBlursAnEdgeByItsCircleOfConfusion) {
  const SceneSource scene(EdgeAt(4));
  const Camera camera = synthetic::Pinhole(100, 4, 200);
  Shutter shutter;
  shutter.aperture = 0.2;
  shutter.focus_distance = 2;
  shutter.samples = 1024;
  const double radius = 0.5 * 0.2 * 200 * std::abs(1 / 4.0 - 1 / 2.0);  // 5 px
  const Photograph photograph = TakePhotograph(scene, camera, Rigid{}, shutter, 1);
  for (int x = 0; x < 100; ++x) {
    const double u = std::clamp((x + 0.5 - 50) / radius, -1.0, 1.0);
    const double expected = 0.5 + (std::asin(u) + u * std::sqrt(1 - u * u)) / std::numbers::pi;
    EXPECT_NEAR(static_cast<double>(photograph.color(x, 2).g), expected, 0.01) << x;
    EXPECT_NEAR(static_cast<double>(photograph.depth(x, 2)), 4, 1e-6);
  }
}

TEST(Shutter, WhatIsInFocusIsSharp) {
  const SceneSource scene(EdgeAt(2));
  Shutter shutter;
  shutter.aperture = 0.5;
  shutter.focus_distance = 2;
  shutter.samples = 16;
  const Photograph photograph =
      TakePhotograph(scene, synthetic::Pinhole(20, 4, 200), Rigid{}, shutter, 1);
  EXPECT_FLOAT_EQ(photograph.color(9, 1).g, 0);
  EXPECT_FLOAT_EQ(photograph.color(10, 1).g, 1);
}

// While the camera moves, or turns, the edge moves evenly over `width` px: a ramp.
void ExpectRamp(const Photograph& photograph, double width) {
  for (int x = 0; x < photograph.color.width(); ++x) {
    const double middle = 0.5 * photograph.color.width();
    const double expected = std::clamp(0.5 + (x + 0.5 - middle) / width, 0.0, 1.0);
    EXPECT_NEAR(static_cast<double>(photograph.color(x, 2).g), expected, 0.03) << x;
  }
}

TEST(Shutter, AMovingCameraBlursByItsWayOverTheDepth) {
  const SceneSource scene(EdgeAt(4));
  Shutter shutter;
  shutter.motion = {0.2, 0, 0};
  shutter.samples = 256;
  ExpectRamp(TakePhotograph(scene, synthetic::Pinhole(60, 4, 200), Rigid{}, shutter, 1),
             200 * 0.2 / 4);
}

TEST(Shutter, ATurningCameraBlursByTheAngle) {
  const SceneSource scene(EdgeAt(400));
  Shutter shutter;
  shutter.turn = {0, 0.05, 0};
  shutter.samples = 256;
  ExpectRamp(TakePhotograph(scene, synthetic::Pinhole(60, 4, 200), Rigid{}, shutter, 1),
             200 * 0.05);
}

// Brown's equation solved here, by its fixed point in long double.
Vector3d Undistorted(const Camera& camera, double px, double py) {
  const auto wide = [](double value) { return static_cast<long double>(value); };
  const std::array<long double, 4> k = {wide(camera.distortion[0]), wide(camera.distortion[1]),
                                        wide(camera.distortion[2]), wide(camera.distortion[3])};
  const long double X = (wide(px) - wide(camera.cx)) / wide(camera.fx);
  const long double Y = (wide(py) - wide(camera.cy)) / wide(camera.fy);
  long double x = X, y = Y;
  for (int i = 0; i < 200; ++i) {
    const long double r2 = x * x + y * y, radial = 1 + k[0] * r2 + k[1] * r2 * r2;
    const long double dx = 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x);
    const long double dy = 2 * k[3] * x * y + k[2] * (r2 + 2 * y * y);
    x = (X - dx) / radial;
    y = (Y - dy) / radial;
  }
  return {static_cast<double>(x), static_cast<double>(y), 1};
}

TEST(Distorted, PixelsSeeAlongTheRaysThatTheLensBendsToThem) {
  Degradation degradation;
  degradation.k1 = -0.2;
  degradation.k2 = 0.05;
  degradation.p1 = 0.003;
  degradation.p2 = -0.002;
  const Camera camera = Distorted(synthetic::Pinhole(80, 60, 60), degradation);
  // z = 6 + 0.5 x - 0.25 y, striped along x.
  Texture stripes;
  stripes.pattern = Texture::Pattern::kGrating;
  stripes.frequency = 0.2;
  stripes.direction = {1, 0, 0};
  stripes.dark = {0, 0, 0};
  stripes.light = {1, 1, 1};
  const Vector3d corner(-40, -40, 6 - 20 + 10);
  const SceneSource scene(
      Evenly({{Parallelogram{corner, {80, 0, 40}, {0, 80, -20}}, stripes, {}}}));
  const Photograph photograph = TakePhotograph(scene, camera, Rigid{}, 1);
  for (int y = 0; y < 60; y += 7) {
    for (int x = 0; x < 80; x += 3) {
      const Vector3d d = Undistorted(camera, x + 0.5, y + 0.5);
      const double z = 6 / (1 - 0.5 * d.x() + 0.25 * d.y());
      EXPECT_NEAR(static_cast<double>(photograph.depth(x, y)), z, 1e-6 * z) << x << " " << y;
      const double phase = 2 * std::numbers::pi * 0.2 * (z * d.x() + 40);
      EXPECT_NEAR(static_cast<double>(photograph.color(x, y).g), 0.5 + 0.5 * std::sin(phase), 0.03)
          << x << " " << y;
    }
  }
}

TEST(Distorted, APictureThatFoldsIsRefused) {
  Degradation degradation;
  degradation.k1 = -1.5;
  EXPECT_THROW(Distorted(synthetic::Pinhole(80, 60, 60), degradation), Error);
}

TEST(Exposures, DriftFromViewToViewByTheirStandardDeviation) {
  Degradation degradation;
  degradation.exposure_ev = 0.3;
  degradation.white_balance_ev = 0.1;
  double exposure = 0, red = 0;
  for (const Exposure& e : ExposuresOf(degradation, 2000, 1, 3)) {
    exposure += std::pow(std::log2(static_cast<double>(e.exposure)), 2) / 2000;
    red += std::pow(std::log2(static_cast<double>(e.red)), 2) / 2000;
  }
  EXPECT_NEAR(std::sqrt(exposure), 0.3, 0.015);  // 3 standard errors
  EXPECT_NEAR(std::sqrt(red), 0.1, 0.005);
}

TEST(Exposures, ScaleTheLight) {
  Exposure exposure;
  exposure.exposure = 0.5F;
  exposure.red = 1.25F;
  exposure.blue = 0.8F;
  Image<Rgb> image(2, 2, {0.4F, 0.4F, 0.4F});
  Degrade({}, exposure, synthetic::Pinhole(2, 2, 2), image);
  EXPECT_FLOAT_EQ(image(1, 1).r, 0.25F);
  EXPECT_FLOAT_EQ(image(1, 1).g, 0.2F);
  EXPECT_FLOAT_EQ(image(1, 1).b, 0.16F);
}

TEST(Exposures, LeaveOutAndRepeatViews) {
  Degradation degradation;
  degradation.dropped_views = 4;
  degradation.duplicated_views = 3;
  const std::vector<Exposure> exposures = ExposuresOf(degradation, 20, 7, 3);
  ASSERT_EQ(exposures.size(), 19U);
  int again = 0;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    if (!exposures[i].again) continue;
    ++again;
    EXPECT_EQ(exposures[i].view, exposures[i - 1].view);
    EXPECT_NE(exposures[i].seed, exposures[i - 1].seed);
  }
  EXPECT_EQ(again, 3);
  degradation.dropped_views = 20;
  EXPECT_THROW(ExposuresOf(degradation, 20, 7, 3), Error);
}

TEST(Exposures, ShakeByTheGivenWayAndAngle) {
  Degradation degradation;
  degradation.shake = 0.02;
  degradation.shake_deg = 0.5;
  for (const Exposure& e : ExposuresOf(degradation, 10, 1, 3)) {
    EXPECT_NEAR(e.shutter.motion.norm(), 0.02, 1e-12);
    EXPECT_NEAR(e.shutter.turn.norm(), 0.5 * std::numbers::pi / 180, 1e-12);
  }
}

TEST(Degrade, IsTheSameWhateverTheThreads) {
  Degradation degradation;
  degradation.full_well_e = 500;
  degradation.read_noise_e = 2;
  degradation.vignetting = 1;
  degradation.aperture = 0.3;
  degradation.shake = 0.05;
  degradation.samples = 8;
  degradation.k1 = -0.05;
  const Exposure exposure = ExposuresOf(degradation, 1, 4, 2).front();
  const Camera camera = Distorted(synthetic::Pinhole(64, 48, 64), degradation);
  const SceneSource scene(EdgeAt(3));
  const auto photograph = [&](int threads) {
    const ThreadLimit limit(threads);
    Photograph taken = TakePhotograph(scene, camera, Rigid{}, exposure.shutter, 2);
    Degrade(degradation, exposure, camera, taken.color);
    return taken;
  };
  const Photograph one = photograph(1), two = photograph(2);
  EXPECT_EQ(std::memcmp(one.color.data(), two.color.data(), one.color.size() * sizeof(Rgb)), 0);
  EXPECT_EQ(std::memcmp(one.depth.data(), two.depth.data(), one.depth.size() * sizeof(float)), 0);
}

}  // namespace
}  // namespace lamella
