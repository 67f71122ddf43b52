#include "distribute/emitter_frame.h"

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/encode_barrier.h"
#include "lightfield/color.h"
#include "lightfield/lenslet_map.h"
#include "tests/reference/analytic_scene.h"

namespace lamella {
namespace {

Display Small(const std::string& name) {
  Display display = FindDisplay(name);
  display.width_px = 36;
  display.height_px = 24;
  return display;
}

EmitterImage Numbered(const Display& display) {
  EmitterImage image{Image<Rgb>(display.emitter_columns(), display.emitter_rows()),
                     Image<float>(display.emitter_columns(), display.emitter_rows(), 1.0F)};
  for (int y = 0; y < image.color.height(); ++y) {
    for (int x = 0; x < image.color.width(); ++x) {
      image.color(x, y) = {Srgb8ToLinear(static_cast<std::uint8_t>(x)),
                           Srgb8ToLinear(static_cast<std::uint8_t>(y)), 0};
    }
  }
  return image;
}

TEST(EmitterFrame, PutsEveryEmitterOnItsPixels) {
  const Display display = Small("paper-two-layer-half");
  const Image<Rgb8> frame = EmitterFrame(Numbered(display), display, 1, PanelResponse::Srgb());
  ASSERT_EQ(frame.width(), 36);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 36; ++x) {
      EXPECT_EQ(frame(x, y).r, x / 2);
      EXPECT_EQ(frame(x, y).g, y / 2);
    }
  }
}

TEST(EmitterFrame, FlipsBothFramesOfALayerSeenByReflection) {
  const Display display = Small("paper-two-layer");
  Display straight = display;
  straight.layers[0].mirror_x = false;
  const EmitterImage image = Numbered(display);
  const Image<Rgb8> flipped = EmitterFrame(image, display, 0, PanelResponse::Srgb());
  const Image<Rgb8> frame = EmitterFrame(image, straight, 0, PanelResponse::Srgb());
  const Image<std::uint8_t> open = ModulatorFrame(straight, 0, 5);
  const Image<std::uint8_t> flipped_open = ModulatorFrame(display, 0, 5);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 36; ++x) {
      EXPECT_EQ(flipped(x, y), frame(35 - x, y));
      EXPECT_EQ(flipped_open(x, y), open(35 - x, y));
    }
  }
  EXPECT_EQ(frame(3, 7).r, 3);
}

// By places of the panel as it is addressed, of all rows or some.
TEST(EmitterFrame, EvensOutThePanel) {
  const Display display = Small("paper-two-layer");
  Calibration calibration = DesignCalibration(display);
  GainMap& evenness = calibration.layers[0].emitter.photometry.evenness;
  evenness = {2, 2, {1, 0.5, 0.8, 0.6}};
  const PanelResponse response = PanelResponse::Of(calibration, 0);
  const EmitterImage grey{Image<Rgb>(36, 24, {0.4F, 0.4F, 0.4F}), Image<float>(36, 24, 1.0F)};
  const Image<Rgb8> frame = EmitterFrame(grey, display, 0, response);
  const double white = CommonWhite(calibration) / calibration.layers[0].gain;
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 36; ++x) {
      const double shown = GainAt(evenness, (x + 0.5) / 36, (y + 0.5) / 24) *
                           static_cast<double>(Srgb8ToLinear(frame(x, y).g));
      EXPECT_NEAR(shown, 0.4 * white, 0.004);
    }
  }
  const EmitterImage rows{Image<Rgb>(36, 4, {0.4F, 0.4F, 0.4F}), Image<float>(36, 4, 1.0F)};
  EXPECT_EQ(EmitterFrame(rows, display, 0, response, 20)(3, 1), frame(3, 21));
}

TEST(EmitterFrame, ShowsNothingWhereNothingIsKnown) {
  const Display display = Small("paper-one-layer");
  EmitterImage image = Numbered(display);
  image.color(5, 5) = {1, 1, 1};
  image.coverage(5, 5) = 0;
  EXPECT_EQ(EmitterFrame(image, display, 0, PanelResponse::Srgb())(5, 5), Rgb8());
}

// Distribution gives them no coverage, whatever the scene.
TEST(EmitterFrame, HasBlackGuardPixels) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 39;
  display.height_px = 36;
  display.varifocal.reset();
  display.layers.resize(1);
  display.layers[0].mirror_x = true;
  AnalyticScene scene;
  scene.rectangles = {{display.layers[0].position_mm, -1e9, 1e9, -1e9, 1e9, [](double, double) {
                         return Rgb{1, 1, 1};
                       }}};
  const LayerImages images = Distribute(scene, display, {}, SilentProgress());
  const Image<Rgb8> frame = EmitterFrame(images.slots[0][0], display, 0, PanelResponse::Srgb());
  const LensletMap map(display, 0);
  int lit = 0;
  for (int y = 0; y < 36; ++y) {
    for (int x = 0; x < 39; ++x) {
      const bool ray = map.Pixel(x, y).has_value();
      lit += ray ? 1 : 0;
      EXPECT_EQ(frame(38 - x, y), ray ? (Rgb8{255, 255, 255}) : Rgb8()) << x << " " << y;
    }
  }
  // Whole lenses of 13 x 11.26 pixels with 6 x 6 rays: 3, 2, and 3 in a row.
  EXPECT_EQ(lit, 8 * 36);
}

TEST(EmitterFrame, KeepsTheChannelsOfALenticularInTheirPixel) {
  Display display = Small("paper-one-layer");
  display.layers[0].optics = Lenticular{};
  EmitterImage image = Numbered(display);
  image.color(7, 3) = {Srgb8ToLinear(10), Srgb8ToLinear(20), Srgb8ToLinear(30)};
  for (const bool mirror : {false, true}) {
    display.layers[0].mirror_x = mirror;
    const Image<Rgb8> frame = EmitterFrame(image, display, 0, PanelResponse::Srgb());
    EXPECT_EQ(frame(mirror ? 28 : 7, 3), (Rgb8{10, 20, 30}));
  }
}

}  // namespace
}  // namespace lamella
