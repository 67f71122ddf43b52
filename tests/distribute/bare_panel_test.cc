// Bare panels: what they are given against the mean of many eyes' lines of sight, and what eyes see
// of them.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/analyze.h"
#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"
#include "lightfield/bandwidth.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"
#include "lightfield/layer_map.h"
#include "tests/reference/analytic_scene.h"
#include "tests/reference/distribute_reference.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

constexpr double kBareDistance = 600, kBarePitch = 0.31;

// Panels of 48x32 px, by their positions.
Display BareDisplay(const std::vector<double>& positions_mm, BarePanel bare, double border_mm = 0) {
  Display display;
  display.name = "bare";
  display.width_px = 48;
  display.height_px = 32;
  display.pitch_mm = kBarePitch;
  display.viewing_distance_mm = kBareDistance;
  display.border_mm = border_mm;
  for (const double z : positions_mm) {
    Layer layer;
    layer.position_mm = z;
    layer.d0_mm = 0;
    layer.optics = bare;
    display.layers.push_back(layer);
  }
  Check(display, "test");
  return display;
}

Rectangle WavesAt(double z, double finest) {
  const auto color = [finest](double x, double y) {
    const double a = std::cos(2 * M_PI * finest * (x * 0.9 + y * 0.4) + 1);
    const double b = std::cos(2 * M_PI * finest * 0.6 * (y - 0.3 * x) + 2);
    return Rgb{static_cast<float>(0.5 + 0.2 * (a + b)), static_cast<float>(0.5 + 0.4 * b),
               static_cast<float>(0.5 - 0.4 * a)};
  };
  return {z, -1e9, 1e9, -1e9, 1e9, color};
}

// What `m` x `m` eyes in the box see through `n` x `n` places of an emitter, on average.
Rgb MeanOverEyes(const AnalyticScene& scene, double layer_mm, double x_mm, double y_mm,
                 double eye_box_mm, int m, int n) {
  Eigen::Vector3d sum(0, 0, 0);
  const auto cell = [](int i, int of) { return (i + 0.5) / of - 0.5; };
  for (int i = 0; i < m * m * n * n; ++i) {
    const Eigen::Vector3d eye(eye_box_mm * cell(i % m, m), eye_box_mm * cell(i / m % m, m),
                              kBareDistance);
    const Eigen::Vector3d at(x_mm + kBarePitch * cell(i / m / m % n, n),
                             y_mm + kBarePitch * cell(i / m / m / n, n), layer_mm);
    const Rgb seen = scene.Trace({eye, at - eye}).color;
    sum += Eigen::Vector3d(static_cast<double>(seen.r), static_cast<double>(seen.g),
                           static_cast<double>(seen.b));
  }
  sum /= m * m * n * n;
  return {static_cast<float>(sum.x()), static_cast<float>(sum.y()), static_cast<float>(sum.z())};
}

double WorstError(const Rgb& a, const Rgb& b) {
  return static_cast<double>(
      std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)}));
}

TEST(BarePanel, ShowsTheMeanOfWhatTheEyesOfItsBoxSee) {
  const BarePanel bare{40, 16};
  for (const double z : {-12.0, 0.0, 5.0, 9.0}) {
    const Display display = BareDisplay({5}, bare);
    AnalyticScene scene;
    scene.rectangles = {WavesAt(z, 0.3), {z + 3, -1, 1.5, -2, 1, [](double, double) {
                                            return Rgb{0.9F, 0.1F, 0.2F};
                                          }}};
    LayersOptions options;
    options.samples_per_pixel = 4;
    const LayerImages images = Distribute(scene, display, options, SilentProgress());
    ASSERT_EQ(images.slots[0].size(), 1U);
    const EmitterImage& shown = images.slots[0][0];
    double sum = 0, worst = 0;
    int count = 0;
    for (int row = 1; row < 32; row += 5) {
      for (int column = 1; column < 48; column += 4) {
        const Rgb mean = MeanOverEyes(scene, 5, (column + 0.5 - 24) * kBarePitch,
                                      (16 - row - 0.5) * kBarePitch, bare.eye_box_mm, 12, 3);
        const double error = WorstError(shown.color(column, row), mean);
        worst = std::max(worst, error);
        sum += error * error;
        ++count;
        EXPECT_NEAR(shown.coverage(column, row), 1, 1e-4);
      }
    }
    EXPECT_LT(std::sqrt(sum / count), 0.005) << z;
    EXPECT_LT(worst, 0.03) << z;  // at the rectangle's edges, which samples stand for
  }
}

// Of the panels' pitch, so high and wide that both panels fill it.
Eye EyeAtMm(double x_mm, double y_mm) {
  Eye eye;
  eye.position = {x_mm, y_mm, kBareDistance};
  eye.left_mm = -5;
  eye.top_mm = 3;
  eye.pixel_mm = kBarePitch;
  eye.width = 32;
  eye.height = 19;
  return eye;
}

TEST(BarePanel, EveryEyeSeesItsPicture) {
  const Display display = BareDisplay({5}, {60, 4});
  AnalyticScene scene;
  scene.rectangles = {WavesAt(5, 0.2)};  // in the panel's plane
  LayersOptions options;
  options.samples_per_pixel = 4;
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  for (const double x : {0.0, -25.0, 200.0}) {
    Eye eye = EyeAtMm(x, -10);
    eye.plane_mm = 5;
    const EyePicture seen = SimulateEye(images, display, eye);
    for (int row = 0; row < eye.height; ++row) {
      for (int column = 0; column < eye.width; ++column) {
        const double px = eye.left_mm + (column + 0.5) * kBarePitch;
        const double py = eye.top_mm - (row + 0.5) * kBarePitch;
        // The eye's pixels lie between the panel's: both blur.
        EXPECT_LT(WorstError(seen.color(column, row), scene.rectangles[0].color(px, py)), 0.02);
        EXPECT_NEAR(seen.coverage(column, row), 1, 1e-5);
      }
    }
  }
}

// Of all that a panel can show, the mean is nearest to what the eyes should see; one eye's own
// picture serves that eye only.
double MeanSquaredError(const Display& display, const AnalyticScene& scene,
                        const LayerImages& images) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < 9; ++i) {
    const int column = i % 3, row = i / 3;
    const Eye eye = EyeAtMm(20.0 * (column - 1), 20.0 * (row - 1));
    const EyePicture seen = SimulateEye(images, display, eye);
    const RayBundle rays = BundleOfEye(eye);
    Image<RaySample> target(rays.width, rays.height);
    scene.Query(rays, {0, 0, rays.width, rays.height}, target.span());
    for (std::size_t p = 0; p < target.size(); ++p) {
      const Rgb d = seen.color.data()[p] - target.data()[p].color;
      sum += static_cast<double>(d.r * d.r + d.g * d.g + d.b * d.b);
      count += 3;
    }
  }
  return sum / count;
}

TEST(BarePanel, TheMeanServesTheEyesOfTheBoxBest) {
  AnalyticScene scene;
  scene.rectangles = {WavesAt(-14, 0.5)};
  const auto error = [&](const BarePanel& bare, const std::vector<double>& positions,
                         double border) {
    const Display display = BareDisplay(positions, bare, border);
    LayersOptions options;
    options.samples_per_pixel = 2;
    return MeanSquaredError(display, scene, Distribute(scene, display, options, SilentProgress()));
  };
  const double mean = error({60, 8}, {0}, 0), middle = error({1e-3, 1}, {0}, 0);
  EXPECT_LT(mean, 0.85 * middle);
  EXPECT_LT(error({60, 8}, {-14, 8}, 0), 0.2 * mean);  // a panel where things are
}

TEST(BarePanel, DepthFusedPanelsShareWhatStandsBetweenThem) {
  const Display display = BareDisplay({-10, 10}, {30, 4}, 20);
  for (const double z : {-10.0, -5.0, 0.0, 5.0, 10.0}) {
    AnalyticScene scene;
    scene.rectangles = {{z, -1e9, 1e9, -1e9, 1e9, [](double, double) {
                           return Rgb{0.8F, 0.4F, 0.2F};
                         }}};
    const LayerImages images = Distribute(scene, display, {}, SilentProgress());
    const auto front = static_cast<float>((z + 10) / 20);
    EXPECT_NEAR(images.slots[0][0].color(20, 10).r, 0.8F * (1 - front), 1e-4);
    EXPECT_NEAR(images.slots[1][0].color(20, 10).r, 0.8F * front, 1e-4);
    Eye eye;
    eye.left_mm = -2;
    eye.top_mm = 2;
    eye.pixel_mm = 0.5;
    eye.width = eye.height = 8;
    const EyePicture seen = SimulateEye(images, display, eye);
    EXPECT_NEAR(seen.color(4, 4).r, 0.8F, 1e-4);
    EXPECT_NEAR(seen.color(4, 4).b, 0.2F, 1e-4);
  }
}

TEST(BarePanel, CalibratedIsAsDesignedWhereNothingIsAskew) {
  const Display display = BareDisplay({-8, 6}, {40, 6}, 4);
  AnalyticScene scene;
  scene.rectangles = {WavesAt(-12, 0.3), {4, -4, 5, -3, 4, [](double, double) {
                                            return Rgb{0.2F, 0.7F, 0.1F};
                                          }}};
  const Calibration design = DesignCalibration(display);
  EXPECT_FALSE(design.layers[0].modulator || design.layers[0].lattice);
  const LayerImages expected = Distribute(scene, display, {}, SilentProgress());
  const LayerImages images = Distribute(scene, display, {}, SilentProgress(), &design);
  for (std::size_t layer = 0; layer < 2; ++layer) {
    for (std::size_t i = 0; i < 48 * 32; ++i) {
      EXPECT_LT(WorstError(images.slots[layer][0].color.data()[i],
                           expected.slots[layer][0].color.data()[i]),
                1e-4);
    }
  }
}

// Linear blending over all of the spacing holds where the panels stand nearer or farther apart.
TEST(BarePanel, CalibratedPanelsBlendOverTheirOwnSpacing) {
  const Display display = BareDisplay({-10, 10}, {30, 2}, 20);
  for (const double nearer : {-0.3, 0.0, 0.3}) {
    Calibration real = DesignCalibration(display);
    real.layers[1].display_from_stack.translation.z() -= nearer;
    EXPECT_LE(AsCalibrated(display, real).border_mm, 20 - nearer);
    AnalyticScene scene;
    scene.rectangles = {WavesAt(0, 0.1)};
    const LayerImages images = Distribute(scene, display, {}, SilentProgress(), &real);
    EXPECT_NEAR(images.slots[0][0].color(20, 10).r / images.slots[1][0].color(20, 10).r, 1, 0.08);
  }
}

TEST(BarePanel, HasNoWindowsThatCouldBeIdeal) {
  const Display display = BareDisplay({5}, {40, 4});
  AnalyticScene scene;
  scene.rectangles = {WavesAt(-12, 0.2)};
  LayersOptions ideal;
  ideal.directions = "ideal";
  const LayerImages a = Distribute(scene, display, {}, SilentProgress());
  const LayerImages b = Distribute(scene, display, ideal, SilentProgress());
  for (std::size_t i = 0; i < 48 * 32; ++i) {
    EXPECT_EQ(a.slots[0][0].color.data()[i], b.slots[0][0].color.data()[i]);
  }
}

TEST(BarePanel, BlursTheMiddleEyesPictureAsWideAsItsBox) {
  const Display display = BareDisplay({5}, {40, 8});
  AnalyticScene scene;
  scene.rectangles = {WavesAt(-12, 0.2)};
  LayersOptions blur;
  blur.prefilter = "blur";
  blur.samples_per_pixel = 2;
  const LayerImages images = Distribute(scene, display, blur, SilentProgress());
  for (int row = 2; row < 30; row += 5) {
    for (int column = 2; column < 46; column += 5) {
      const Rgb mean = MeanOverEyes(scene, 5, (column + 0.5 - 24) * kBarePitch,
                                    (16 - row - 0.5) * kBarePitch, 40, 12, 3);
      EXPECT_LT(WorstError(images.slots[0][0].color(column, row), mean), 0.02);
    }
  }
}

// A panel that stands elsewhere shows what eyes see through where its emitters really are.
TEST(BarePanel, FollowsACalibration) {
  const Display display = BareDisplay({5}, {30, 6});
  Calibration askew = DesignCalibration(display);
  askew.layers[0].display_from_stack.translation = {2, -1, 7};
  askew.layers[0].display_from_stack.rotation = Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitZ()) *
                                                Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY());
  AnalyticScene scene;
  scene.rectangles = {WavesAt(12, 0.15)};
  LayersOptions options;
  options.samples_per_pixel = 4;
  const LayerImages images = Distribute(scene, display, options, SilentProgress(), &askew);
  for (int row = 1; row < 32; row += 6) {
    for (int column = 1; column < 48; column += 7) {
      const Eigen::Vector3d at =
          askew.layers[0].display_from_stack *
          Eigen::Vector3d((column + 0.5 - 24) * kBarePitch, (16 - row - 0.5) * kBarePitch, 0);
      const Rgb mean = MeanOverEyes(scene, at.z(), at.x(), at.y(), 30, 8, 3);
      EXPECT_LT(WorstError(images.slots[0][0].color(column, row), mean), 0.01);
    }
  }
}

TEST(BarePanel, HasTheBandwidthOfOneDirection) {
  const Display display = BareDisplay({5}, {60, 8});
  const Layer& layer = display.layers[0];
  EXPECT_DOUBLE_EQ(SharpRangeMm(display, layer), (kBareDistance - 5) * kBarePitch / 60);
  EXPECT_EQ(DirectionsPerAxis(layer), 1);
  EXPECT_DOUBLE_EQ(Brightness(display, layer), 1);
  EXPECT_DOUBLE_EQ(CleanEyeBox(display), 30);
  EXPECT_EQ(RaysOf(display, layer), 48 * 32);
  // Of content dz before it, a line of sight through an emitter moves by E dz / (D - z) with the
  // eye.
  const double dz = 12, width = 60 * dz / (kBareDistance - 5), f = 0.1;
  EXPECT_NEAR(Mtf(MiddleBeam(display, layer), dz, f),
              std::abs(std::sin(M_PI * f * width) / (M_PI * f * width)) *
                  std::sin(M_PI * f * kBarePitch * (1 - dz / 595)) /
                  (M_PI * f * kBarePitch * (1 - dz / 595)),
              1e-9);
}

TEST(BarePanel, StaysRightAtTheExtremes) {
  AnalyticScene scene;
  scene.rectangles = {WavesAt(-1e4, 0.001)};
  for (const BarePanel& bare : {BarePanel{1e-6, 1}, BarePanel{1e-6, 256}, BarePanel{1000, 3}}) {
    const Display display = BareDisplay({-1e-6, 1e-6}, bare);
    const LayerImages images = Distribute(scene, display, {}, SilentProgress());
    for (const auto& layer : images.slots) {
      for (std::size_t i = 0; i < layer[0].color.size(); ++i) {
        EXPECT_TRUE(std::isfinite(layer[0].color.data()[i].r));
        EXPECT_NEAR(layer[0].coverage.data()[i], 1, 1e-3);
      }
    }
  }
}

// A box much smaller than a barrier's fan would be the step of all its eyes.
TEST(BarePanel, RefusesABoxThatAsksForTooManyEyes) {
  Display display = BareDisplay({-10, 10}, {0.001, 256});
  display.layers[1].optics = Barrier{6, 2, 3};
  display.layers[1].d0_mm = 5;
  try {
    Distribute(AnalyticScene(), display, {}, SilentProgress());
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("wider eye_box_mm"));
  }
}

TEST(BarePanel, IsReadAndWritten) {
  const Display display = FindDisplay("depth-fused");
  ASSERT_TRUE(std::holds_alternative<BarePanel>(display.layers[1].optics));
  EXPECT_EQ(std::get<BarePanel>(display.layers[1].optics).eye_box_mm, 80);
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
  const auto refusal = [](const std::string& layer) -> std::string {
    try {
      ParseDisplay(
          "name = \"b\"\nviewing_distance_mm = 600\n[panel]\nwidth_px = 9\nheight_px = 9\n"
          "pitch_mm = 0.3\n[[layer]]\nposition_mm = 0\n" +
              layer,
          "b.toml");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal("[layer.bare]\n"), "");
  EXPECT_THAT(refusal("d0_mm = 3\n[layer.bare]\n"), HasSubstr("d0_mm beside [layer.bare]"));
  EXPECT_THAT(refusal("[layer.bare]\neye_box_mm = 0\n"), HasSubstr("eye_box_mm"));
  EXPECT_THAT(refusal("[layer.bare]\neye_box_mm = inf\n"), HasSubstr("eye_box_mm"));
  EXPECT_THAT(refusal("[layer.bare]\nviews = 0\n"), HasSubstr("views = 0"));
  EXPECT_THAT(refusal("[layer.bare]\nrays = 3\n"), HasSubstr("rays"));
  EXPECT_THAT(refusal("[layer.bare]\n[layer.barrier]\nperiod_px = 2\n"), HasSubstr("beside"));
  EXPECT_THAT(refusal(""), HasSubstr("[layer.bare]"));
}

}  // namespace
}  // namespace lamella
