// Shimmer as an eye moves, of pictures made by hand and of gratings on a display, against targets
// in closed form.
#include "distribute/angular_aliasing.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "tests/distribute/centred_eye.h"
#include "tests/reference/analytic_scene.h"

namespace lamella {
namespace {

constexpr double kAliasingViewerMm = 600, kAliasingPixelMm = 0.1;

Eye AliasingEye(double x, int width) {
  return CentredEye({x, 0, kAliasingViewerMm}, kAliasingPixelMm, width, 1);
}

// Of a plane: seen and target by the place on it, mm.
using LightOnPlane = std::function<double(double x)>;
SeenAgainstTarget SeenOf(double eye_x, int width, double z, const LightOnPlane& seen,
                         const LightOnPlane& target) {
  SeenAgainstTarget a{AliasingEye(eye_x, width), Image<float>(width, 1), Image<float>(width, 1),
                      Image<float>(width, 1, static_cast<float>(z)), Image<float>(width, 1, 1)};
  for (int x = 0; x < width; ++x) {
    const double on_picture = a.eye.left_mm + (x + 0.5) * kAliasingPixelMm;
    const double on_plane =
        eye_x + (on_picture - eye_x) * (kAliasingViewerMm - z) / kAliasingViewerMm;
    a.seen(x, 0) = static_cast<float>(seen(on_plane));
    a.target(x, 0) = static_cast<float>(target(on_plane));
  }
  return a;
}

double ErrorWave(double x) { return 0.2 * std::cos(2 * M_PI * 0.3 * x); }

TEST(AngularAliasing, IsNotWhatMovesWithTheScene) {
  const auto half = [](double) { return 0.5; };
  const auto seen = [](double x) { return 0.5 + ErrorWave(x); };
  for (const double z : {-40.0, 0.0, 25.0}) {
    const double db =
        *AngularAliasing(SeenOf(0, 400, z, seen, half), SeenOf(9, 400, z, seen, half), 0);
    EXPECT_LT(db, -50) << z;  // what linear interpolation leaves
  }
}

TEST(AngularAliasing, IsTheMeanSquareOfWhatChanges) {
  const auto half = [](double) { return 0.5; };
  const auto seen = [](double x) { return 0.5 + ErrorWave(x); };
  const auto inverse = [](double x) { return 0.5 - ErrorWave(x); };
  // From + to - 0.2 cos: (0.4)^2 / 2 over 1/4.
  const double db =
      *AngularAliasing(SeenOf(0, 400, 25, seen, half), SeenOf(9, 400, 25, inverse, half), 0);
  EXPECT_NEAR(db, 10 * std::log10(0.08 / 0.25), 0.1);
}

TEST(AngularAliasing, LeavesOutWhatTheOtherEyeDoesNotSee) {
  const auto half = [](double) { return 0.5; };
  const auto dark = [](double) { return 0.1; };
  const SeenAgainstTarget a = SeenOf(0, 100, 20, half, half);
  SeenAgainstTarget b = SeenOf(3, 100, 20, dark, half);
  const double all = *AngularAliasing(a, b, 0);
  EXPECT_NEAR(all, 10 * std::log10(0.16 / 0.25), 1e-4);
  for (int x = 0; x < 40; ++x) b.z(x, 0) = 60;
  for (int x = 40; x < 100; ++x) b.known(x, 0) = 0;
  EXPECT_FALSE(AngularAliasing(a, b, 0));
  b = SeenOf(3, 100, 20, half, half);
  EXPECT_EQ(*AngularAliasing(a, b, 0), -std::numeric_limits<double>::infinity());
  EXPECT_FALSE(AngularAliasing(a, b, 1)) << "a border as wide as the picture";
}

TEST(AngularAliasing, StepsAQuarterOfTheLeastSpacingOfViews) {
  // 37.358 mm at 600 mm from the modulating plane (displays.md); the front layer is nearer.
  EXPECT_NEAR(AliasingStepMm(FindDisplay("paper-two-layer")), 37.358 * 590 / 600 / 4, 1e-3);
}

// A grating at twice the sharp range, on a display of one layer made with this kernel.
struct WatchedGrating {
  double frequency = 0, contrast = 0;
  Rgb ColorAt(double x) const {
    const auto light = static_cast<float>(0.5 + contrast * std::cos(2 * M_PI * frequency * x));
    return {light, light, light};
  }
  double Decibels(const std::string& kernel) const;
};

double WatchedGrating::Decibels(const std::string& kernel) const {
  constexpr double kPlane = 20;
  Display display = FindDisplay("paper-one-layer");
  display.width_px = 120;
  display.height_px = 6;
  AnalyticScene scene;
  scene.rectangles = {
      {kPlane, -1e9, 1e9, -1e9, 1e9, [this](double x, double) { return ColorAt(x); }}};
  LayersOptions options;
  options.kernel = kernel;
  options.nodes_per_step = kernel == "ray" ? 1 : 4;
  options.samples_per_pixel = 3;
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  const auto look = [&](double eye_x) {
    const auto target = [this](double x) { return static_cast<double>(ColorAt(x).g); };
    SeenAgainstTarget a = SeenOf(eye_x, 200, kPlane, target, target);
    const EyePicture picture = SimulateEye(images, display, a.eye);
    for (int x = 0; x < a.eye.width; ++x) a.seen(x, 0) = picture.color(x, 0).g;
    return a;
  };
  const std::optional<double> db = AngularAliasing(look(0), look(AliasingStepMm(display)), 0);
  return db.value();
}

// Experiment 6: from 1.75 times the cut-off on, 0.4 cycles/mm at this depth, the prefilter takes
// 10 dB and more.
TEST(AngularAliasing, TellsAPrefilteredDisplayFromOneOfRays) {
  for (const double frequency : {0.7, 1.0}) {
    const WatchedGrating grating{frequency, 0.4};
    EXPECT_LT(grating.Decibels("beam"), grating.Decibels("ray") - 10) << frequency;
  }
}

TEST(AngularAliasing, OfAFlatSceneIsNoise) {
  const WatchedGrating flat{0.1, 0};
  for (const char* kernel : {"beam", "ray"}) EXPECT_LT(flat.Decibels(kernel), -60) << kernel;
}

}  // namespace
}  // namespace lamella
