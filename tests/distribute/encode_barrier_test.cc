#include "distribute/encode_barrier.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/color.h"

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

TEST(EmitterFrame, ShowsNothingWhereNothingIsKnown) {
  const Display display = Small("paper-one-layer");
  EmitterImage image = Numbered(display);
  image.color(5, 5) = {1, 1, 1};
  image.coverage(5, 5) = 0;
  EXPECT_EQ(EmitterFrame(image, display, 0, PanelResponse::Srgb())(5, 5), Rgb8());
}

TEST(ModulatorFrame, OpensSquaresOfTheApertureEveryPeriod) {
  const Display display = Small("paper-one-layer");
  for (int slot = 0; slot < 9; ++slot) {
    const Image<std::uint8_t> frame = ModulatorFrame(display, 0, slot);
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 36; ++x) {
        const bool open = x % 6 / 2 == slot % 3 && y % 6 / 2 == slot / 3;
        EXPECT_EQ(frame(x, y), open ? 255 : 0);
      }
    }
  }
}

TEST(PanelResponse, GivesTheNearestCode) {
  const PanelResponse srgb = PanelResponse::Srgb();
  const PanelResponse gamma = PanelResponse::Gamma(2.2), linear = PanelResponse::Gamma(1);
  for (int i = 0; i <= 100000; ++i) {
    const float light = static_cast<float>(i) / 100000;
    const double l = static_cast<double>(light);
    const double curve = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
    EXPECT_LE(std::abs(srgb.Code(light) - 255 * curve), 0.5 + 1e-3) << light;
    const double encoded = 255 * std::pow(static_cast<double>(light), 1 / 2.2);
    EXPECT_LE(std::abs(gamma.Code(light) - encoded), 0.5 + 1e-4) << light;
    EXPECT_LE(std::abs(linear.Code(light) - 255 * static_cast<double>(light)), 0.5 + 1e-4);
  }
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(srgb.Code(Srgb8ToLinear(static_cast<std::uint8_t>(code))), code);
  }
  EXPECT_EQ(srgb.Code(-1), 0);
  EXPECT_EQ(srgb.Code(std::nanf("")), 0);
  EXPECT_EQ(srgb.Code(INFINITY), 255);
  EXPECT_EQ(srgb.Code(2), 255);
}

TEST(SlotOrder, TouchesEveryRowAndColumnOfSlotsInAnyRun) {
  for (const int k : {1, 2, 3, 4, 6}) {
    const std::vector<int> order = SlotOrder(k);
    EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), static_cast<std::size_t>(k * k));
    for (int t = 0; t + k <= k * k; t += k) {
      std::set<int> columns, rows;
      for (int i = t; i < t + k; ++i) {
        columns.insert(order[static_cast<std::size_t>(i)] % k);
        rows.insert(order[static_cast<std::size_t>(i)] / k);
      }
      EXPECT_EQ(columns.size(), static_cast<std::size_t>(k));
      EXPECT_EQ(rows.size(), static_cast<std::size_t>(k));
    }
  }
}

}  // namespace
}  // namespace lamella
