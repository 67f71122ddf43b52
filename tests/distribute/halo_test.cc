// Where halos are looked for, against the beams' widths by hand, and how strong they are, against
// the step response of the beams' boxes.
#include "distribute/halo.h"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "tests/distribute/centred_eye.h"
#include "tests/reference/analytic_scene.h"

namespace lamella {
namespace {

constexpr double kHaloPitchMm = 0.311316, kHaloGapMm = 5,
                 kHaloViewerMm = 600;  // of the paper's displays, mm
constexpr float kBehindAll = std::numeric_limits<float>::infinity();

Eye HaloEye(int width, int height, double pixel_mm) {
  return CentredEye({0, 0, kHaloViewerMm}, pixel_mm, width, height);
}

SeenScene DepthsOf(const Eye& eye, const std::function<float(int, int)>& z) {
  SeenScene scene{Image<Rgb>(eye.width, eye.height, {1, 1, 1}), Image<float>(eye.width, eye.height),
                  Image<float>(eye.width, eye.height, 1)};
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) scene.z(x, y) = z(x, y);
  }
  return scene;
}

ShadowBlur PaperBlur() { return ShadowBlurOf(FindDisplay("paper-two-layer")).value(); }

TEST(Halo, RimsReachAsFarAsTheShadowsTwoBlurs) {
  const Eye eye = HaloEye(400, 9, 0.1);
  for (const double near : {2.1, 10.0, 17.0}) {
    for (const float far : {-10.0F, -25.0F, -kBehindAll}) {
      const SeenScene scene =
          DepthsOf(eye, [&](int x, int) { return x < 200 ? static_cast<float>(near) : far; });
      const Image<Rim> rims = RimsOf(scene, PaperBlur(), eye);
      ASSERT_FALSE(rims.empty());
      const double offset = near + 10;  // from the back layer
      const double width_mm =
          2 * kHaloPitchMm * (1 + offset / kHaloGapMm) + kHaloPitchMm * offset / kHaloGapMm;
      const int reach =
          static_cast<int>(std::ceil(width_mm / 0.1 * kHaloViewerMm / (kHaloViewerMm - near)));
      for (int x = 0; x < eye.width; ++x) {
        const Rim expected = x < 200 - reach || x >= 200 + reach ? Rim::kNone
                             : x < 200                           ? Rim::kBefore
                                                                 : Rim::kBehind;
        ASSERT_EQ(rims(x, 4), expected) << x << ", " << near << " before " << far;
      }
    }
  }
}

TEST(Halo, OfATallEdgeIsAcrossIt) {
  const Eye eye = HaloEye(7, 300, 0.2);
  const SeenScene scene = DepthsOf(eye, [](int, int y) { return y < 150 ? -10.0F : 10.0F; });
  const Image<Rim> rims = RimsOf(scene, PaperBlur(), eye);
  for (int x = 0; x < eye.width; ++x) {
    EXPECT_EQ(rims(x, 149), Rim::kBehind);
    EXPECT_EQ(rims(x, 150), Rim::kBefore);
    EXPECT_EQ(rims(x, 80), Rim::kNone);
    EXPECT_EQ(rims(x, 220), Rim::kNone);
  }
}

// A slope from one layer's depths to the other's, however steep, hides nothing from the display's
// directions until it is steeper than they are: 5 mm of depth for 3 pitches.
TEST(Halo, IsNotOfSlopes) {
  const Eye eye = HaloEye(400, 3, 0.1);
  const double limit = kHaloGapMm / (3 * kHaloPitchMm);
  for (const double slope : {0.4, 3.0, 0.95 * limit}) {
    const SeenScene scene =
        DepthsOf(eye, [&](int x, int) { return static_cast<float>(slope * 0.1 * (x - 200)); });
    EXPECT_TRUE(RimsOf(scene, PaperBlur(), eye).empty()) << slope;
  }
  const SeenScene steep =
      DepthsOf(eye, [&](int x, int) { return static_cast<float>(1.2 * limit * 0.1 * (x - 200)); });
  EXPECT_FALSE(RimsOf(steep, PaperBlur(), eye).empty());
}

TEST(Halo, IsThereBetweenLayersOfWhatIsKnownOnly) {
  EXPECT_FALSE(ShadowBlurOf(FindDisplay("paper-one-layer")));
  const Eye eye = HaloEye(100, 3, 0.3);
  const SeenScene one_layer = DepthsOf(eye, [](int x, int) { return x < 50 ? 18.0F : 3.0F; });
  EXPECT_TRUE(RimsOf(one_layer, PaperBlur(), eye).empty());
  SeenScene unknown = DepthsOf(eye, [](int x, int) { return x < 50 ? 18.0F : -9.0F; });
  for (int y = 0; y < eye.height; ++y) unknown.coverage(50, y) = 0;
  EXPECT_TRUE(RimsOf(unknown, PaperBlur(), eye).empty());
}

TEST(Halo, AddsUpTheErrorsOfEachSide) {
  Image<Rgb8> target(6, 3, {188, 188, 188}), seen = target.Clone();
  Image<Rim> rims(6, 3);
  rims(1, 1) = Rim::kBehind;
  rims(2, 1) = Rim::kBefore;
  seen(1, 1) = {0, 0, 0};
  seen(2, 1) = {255, 255, 255};
  seen(3, 1) = {0, 0, 0};
  seen(0, 0) = {0, 0, 0};  // in the border
  const HaloErrors errors = SumHaloErrors(seen.span(), target.span(), rims, {1, {}});
  const double light = std::pow((188 / 255.0 + 0.055) / 1.055, 2.4);
  EXPECT_NEAR(errors.behind.error, -light, 1e-6);
  EXPECT_NEAR(errors.before.error, 1 - light, 1e-6);
  EXPECT_EQ(errors.elsewhere.pixels, 2);
  const HaloFigures figures = FiguresOf(errors).value();
  EXPECT_NEAR(*figures.behind, -1, 1e-6);
  EXPECT_NEAR(*figures.before, 1 / light - 1, 1e-5);
  EXPECT_NEAR(*figures.relative_error, (1 - 2 * light) / (2 * light), 1e-5);
  EXPECT_EQ(figures.share_of_pixels, 0.5);
  const double squares = light * light + (1 - light) * (1 - light);
  EXPECT_NEAR(figures.share_of_squared_error, squares / (squares + light * light), 1e-6);
  EXPECT_FALSE(FiguresOf(SumHaloErrors(seen.span(), target.span(), Image<Rim>(6, 3), {1, {}})));
}

// The mean of |t| under boxes of these widths applied one after the other, by sums of samples: what
// a step loses on one side, times two.
double MeanDistance(const std::vector<double>& widths_mm) {
  constexpr double kStep = 0.01;
  std::vector<double> density = {1};
  for (const double width : widths_mm) {
    const auto count = static_cast<std::size_t>(std::lround(width / kStep));
    if (count == 0) continue;
    std::vector<double> next(density.size() + count - 1);
    for (std::size_t i = 0; i < density.size(); ++i) {
      for (std::size_t j = 0; j < count; ++j)
        next[i + j] += density[i] / static_cast<double>(count);
    }
    density = next;
  }
  double mean = 0;
  const double middle = static_cast<double>(density.size() - 1) / 2;
  for (std::size_t i = 0; i < density.size(); ++i) {
    mean += density[i] * kStep * std::abs(static_cast<double>(i) - middle);
  }
  return mean;
}

// What eyes over a step of view see wrongly of a bar in the front layer before a white plane in the
// back one, mean over lattice phases of the bar.
HaloErrors ErrorsOfBar(float bar_light) {
  constexpr double kHalfBar = 8, kFar = 1e6, kBarPixelMm = 0.1;
  Display display = FindDisplay("paper-two-layer");
  display.layers[0].position_mm = -5;
  display.layers[1].position_mm = 5;
  display.border_mm = display.border_offset_mm = 0;
  display.shear = false;
  display.width_px = 150;
  display.height_px = 6;
  LayersOptions options;
  options.nodes_per_step = 4;
  options.samples_per_pixel = 2;
  HaloErrors errors;
  for (const double middle : {0.0, 0.21, 0.42}) {
    AnalyticScene scene;
    scene.rectangles = {{-5, -1e9, 1e9, -1e9, 1e9,
                         [](double, double) {
                           return Rgb{0.5F, 0.5F, 0.5F};
                         }},
                        {5, middle - kHalfBar, middle + kHalfBar, -1e9, 1e9, [=](double, double) {
                           return Rgb{bar_light, bar_light, bar_light};
                         }}};
    const LayerImages images = Distribute(scene, display, options, SilentProgress());
    for (int i = 0; i < 8; ++i) {
      Eye eye = HaloEye(300, 1, kBarPixelMm);
      eye.position = {((i + 0.5) / 8 - 0.5) * kHaloPitchMm / kHaloGapMm * (kFar - 5), 0, kFar};
      eye.plane_mm = 5;
      const auto is_bar = [&](int x, int) {
        return std::abs(eye.left_mm + (x + 0.5) * kBarPixelMm - middle) < kHalfBar;
      };
      const SeenScene seen_scene =
          DepthsOf(eye, [&](int x, int y) { return is_bar(x, y) ? 5.0F : -5.0F; });
      Image<Rgb> target(eye.width, 1, {0.5F, 0.5F, 0.5F});
      for (int x = 0; x < eye.width; ++x) {
        if (is_bar(x, 0)) target(x, 0) = {bar_light, bar_light, bar_light};
      }
      const Image<Rgb8> seen = EncodeSrgb8(SimulateEye(images, display, eye).color.span());
      errors += SumHaloErrors(seen.span(), EncodeSrgb8(target.span()).span(),
                              RimsOf(seen_scene, ShadowBlurOf(display).value(), eye), {});
    }
  }
  return errors;
}

// Of light that is the same before and behind, the nearer layer's own edge is twice as wide as the
// openings' box, the shadow's twice as wide as both boxes at 10 mm; where they differ is the halo,
// dark outside and bright inside in equal parts, and nothing of it lies beyond the rims.
TEST(Halo, IsWhatTheStepResponsesLeave) {
  const double own = MeanDistance({2 * kHaloPitchMm, 2 * kHaloPitchMm});
  const double opening = 2 * kHaloPitchMm * 3, emitter = kHaloPitchMm * 2;
  const double shadow = MeanDistance({opening, emitter, opening, emitter});
  const HaloErrors errors = ErrorsOfBar(0.5F);
  const double per_rim = 0.5 * (own - shadow) / 2;
  constexpr double kRims = 2 * 24, kBarPixelMm = 0.1;
  EXPECT_NEAR(errors.behind.error * kBarPixelMm / kRims, per_rim, 0.1 * std::abs(per_rim));
  EXPECT_NEAR(errors.before.error * kBarPixelMm / kRims, -per_rim, 0.1 * std::abs(per_rim));
  EXPECT_LT(errors.elsewhere.squared_error, 0.002 * errors.behind.squared_error);
  EXPECT_GT(FiguresOf(errors)->share_of_squared_error, 0.99);
}

// A dark bar's rims are of what it hides: the white that leaks onto it.
TEST(Halo, OfADarkBarLeaksOntoIt) {
  const HaloFigures figures = FiguresOf(ErrorsOfBar(0.05F)).value();
  EXPECT_LT(*figures.behind, -0.1);
  EXPECT_GT(*figures.before, 1);
}

TEST(Halo, DoesNotDependOnThreads) {
  const Eye eye = HaloEye(150, 130, 0.4);
  const SeenScene scene =
      DepthsOf(eye, [](int x, int y) { return (x / 20 + y / 17) % 2 == 0 ? -12.0F : 9.0F; });
  Image<Rim> rims[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    rims[threads - 1] = RimsOf(scene, PaperBlur(), eye);
  }
  for (std::size_t i = 0; i < rims[0].size(); ++i) ASSERT_EQ(rims[0].data()[i], rims[1].data()[i]);
}

}  // namespace
}  // namespace lamella
