// Displays and scenes at the ends of what numbers allow, from rays to codes and to the eye: right
// by a closed form, or refused with one clear line.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/assign.h"
#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/emitter_frame.h"
#include "distribute/encode_barrier.h"
#include "distribute/simulate_eye.h"
#include "lightfield/error.h"
#include "tests/reference/analytic_scene.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Display Small(const std::string& name) {
  Display display = FindDisplay(name);
  display.width_px = 64;
  display.height_px = 48;
  return display;
}

Display Layers(int count, double spacing_mm) {
  Display display = Small("paper-one-layer");
  display.layers.assign(static_cast<std::size_t>(count), display.layers[0]);
  for (int i = 0; i < count; ++i) {
    display.layers[static_cast<std::size_t>(i)].position_mm = (i - (count - 1) / 2.0) * spacing_mm;
  }
  return display;
}

// One colour everywhere at one depth: a plane, or the background at -inf.
class Wall final : public RaySource {
 public:
  Wall(double z, float light) : z_(z), light_(light) {}

  void Query(const RayBundle& bundle, const Rect& rect,
             ImageSpan<RaySample> samples) const override {
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        RaySample& sample = samples(x, y);
        sample.color = {light_, light_, light_};
        sample.z = static_cast<float>(z_ - bundle.origin.z());
        sample.confidence = sample.coverage = 1;
      }
    }
  }

 private:
  double z_;
  float light_;
};

LayerImages Distributed(const RaySource& source, const Display& display) {
  Check(display, "the test's display");
  LayerImages images = Distribute(source, display, {}, SilentProgress());
  EXPECT_GT(images.seen_share, 0.99);
  for (const auto& slots : images.slots) {
    for (const EmitterImage& image : slots) {
      for (std::size_t i = 0; i < image.color.size(); ++i) {
        EXPECT_TRUE(std::isfinite(image.color.data()[i].g));
      }
    }
  }
  return images;
}

// The middle half of the panel seen from the middle of the clean eye box.
EyePicture Seen(const LayerImages& images, const Display& display) {
  Eye eye;
  eye.position = {0, 0, display.viewing_distance_mm};
  eye.width = 16;
  eye.height = 12;
  eye.pixel_mm = display.width_mm() / 2 / eye.width;
  eye.left_mm = -display.width_mm() / 4;
  eye.top_mm = display.height_mm() / 4;
  return SimulateEye(images, display, eye);
}

void ExpectTheEyeSees(const LayerImages& images, const Display& display, double light) {
  const EyePicture picture = Seen(images, display);
  for (std::size_t i = 0; i < picture.color.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(picture.coverage.data()[i]), 1, 1e-5);
    EXPECT_NEAR(static_cast<double>(picture.color.data()[i].g), light, 1e-4 * light);
  }
}

std::string Refusal(const Display& display) {
  try {
    Check(display, "mine.toml");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_THAT(error.what(), HasSubstr("mine.toml: "));
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    return error.what();
  }
  return "accepted";
}

TEST(Gap, OfNothingOrAMillionthIsRefusedWhereTheFanWouldBeFlat) {
  Display display = Small("paper-two-layer");
  display.layers[1].d0_mm = 0;
  EXPECT_THAT(Refusal(display), HasSubstr("layer 1: the gap d0_mm = 0"));
  display.layers[1].d0_mm = 1e-6;
  EXPECT_THAT(Refusal(display), HasSubstr("layer 1: the gap d0_mm = 1e-06 makes a fan of 180"));
}

// The same display in other units: every picture is the same.
TEST(Gap, OfAMillionthBehindAsSmallOpeningsIsRight) {
  constexpr double kScale = 2e-7;  // d0 = 1e-6 mm
  const Display large = Small("paper-two-layer");
  Display tiny = large;
  tiny.pitch_mm *= kScale;
  tiny.viewing_distance_mm *= kScale;
  tiny.border_mm *= kScale;
  for (Layer& layer : tiny.layers) {
    layer.position_mm *= kScale;
    layer.d0_mm *= kScale;
  }
  EXPECT_NEAR(tiny.layers[0].d0_mm, 1e-6, 1e-18);
  const auto ramp = [](double scale) {
    return [scale](double x, double y) {
      const auto light = static_cast<float>(0.5 + 0.02 * (x - y) / scale);
      return Rgb{light, light, light};
    };
  };
  AnalyticScene in_large, in_tiny;
  in_large.rectangles = {{3, -kInfinity, kInfinity, -kInfinity, kInfinity, ramp(1)}};
  in_tiny.rectangles = {{3 * kScale, -kInfinity, kInfinity, -kInfinity, kInfinity, ramp(kScale)}};
  const LayerImages large_images = Distributed(in_large, large);
  const LayerImages tiny_images = Distributed(in_tiny, tiny);
  const EyePicture a = Seen(large_images, large), b = Seen(tiny_images, tiny);
  for (std::size_t i = 0; i < a.color.size(); ++i) {
    EXPECT_NEAR(a.color.data()[i].g, b.color.data()[i].g, 1e-4F);
  }
}

TEST(Period, OfOnePixelShowsEveryEmitterThroughItsOwnOpening) {
  Display display = Small("paper-one-layer");
  display.layers[0].optics = Barrier{1, 1, 1};
  const LayerImages images = Distributed(Wall(0, 0.5F), display);
  ExpectTheEyeSees(images, display, 0.5);
  const Image<std::uint8_t> open = ModulatorFrame(display, 0, 0);
  EXPECT_EQ(std::count(open.data(), open.data() + open.size(), 255), 64 * 48);
}

TEST(LayerSpacing, OfAMillionthShowsAWallOnceWhicheverLayerHasIt) {
  for (const int count : {2, 64}) {
    const Display display = Layers(count, 1e-6);
    for (const double z : {-7.0, 0.0, 1.3e-6, 7.0}) {
      ExpectTheEyeSees(Distributed(Wall(z, 0.5F), display), display, 0.5);
    }
  }
}

TEST(LayerSpacing, OfNothingIsRefused) {
  EXPECT_THAT(Refusal(Layers(2, 0)), HasSubstr("no two at one place"));
}

TEST(LayerCount, Of64ShowsEachWallInTheLayerWhereItStands) {
  const Display display = Layers(64, 0.5);
  for (const int layer : {0, 17, 63}) {
    const double z = display.layers[static_cast<std::size_t>(layer)].position_mm;
    const LayerImages images = Distributed(Wall(z, 0.5F), display);
    ExpectTheEyeSees(images, display, 0.5);
    for (int l = 0; l < 64; ++l) {
      const EmitterImage& image = images.slots[static_cast<std::size_t>(l)][0];
      EXPECT_NEAR(image.color(30, 20).g, l == layer ? 0.5F : 0.0F, 1e-6F) << l;
    }
  }
}

TEST(ViewingDistance, InsideTheDisplayIsRefused) {
  Display display = Small("paper-two-layer");
  for (const double inside : {-20.0, 0.0, 1e-6, 9.999, 10.0, 14.999}) {
    display.viewing_distance_mm = inside;
    EXPECT_THAT(Refusal(display), HasSubstr("viewing_distance_mm"));
  }
}

TEST(ViewingDistance, JustInFrontOrTheFarthestIsRight) {
  Display display = Small("paper-two-layer");
  for (const double distance : {15.001, 1e6}) {
    display.viewing_distance_mm = distance;
    ExpectTheEyeSees(Distributed(Wall(2, 0.5F), display), display, 0.5);
  }
}

// Weights change linearly over the border, 1/2 in its middle.
TEST(Border, OfNothingAndOfTheWholeSpacingSplitTheLight) {
  Display display = Small("paper-two-layer");  // at -10 and 10 mm
  for (const double border : {0.0, 1e-9, 20.0}) {
    display.border_mm = border;
    for (const double z : {-9.0, -4.0, 5.0, 9.0}) {
      const LayerImages images = Distributed(Wall(z, 0.5F), display);
      ExpectTheEyeSees(images, display, 0.5);
      const double front = border < 1 ? (z > 0 ? 1.0 : 0.0) : 0.5 + z / border;
      EXPECT_NEAR(static_cast<double>(images.slots[1][4].color(30, 20).g), 0.5 * front, 1e-5);
      EXPECT_NEAR(static_cast<double>(images.slots[0][4].color(30, 20).g), 0.5 * (1 - front), 1e-5);
    }
  }
  display.border_mm = 20.001;
  EXPECT_THAT(Refusal(display), HasSubstr("border_mm = 20.001"));
}

// z of the display's frame: a millionth before the eye, on both sides of z = 0, and at infinity.
TEST(SceneDepth, FromAMillionthToInfinityGoesToTheOutermostLayers) {
  const Display display = Small("paper-two-layer");
  for (const double z : {600 - 1e-6, 1e-6, -1e-6, -1e6, -1e30, -kInfinity}) {
    const LayerImages images = Distributed(Wall(z, 0.5F), display);
    ExpectTheEyeSees(images, display, 0.5);
    if (std::abs(z) < 1) continue;
    const float front = images.slots[1][4].color(30, 20).g,
                back = images.slots[0][4].color(30, 20).g;
    EXPECT_NEAR(z > 0 ? front : back, 0.5F, 1e-5F) << z;
    EXPECT_EQ(z > 0 ? back : front, 0) << z;
  }
}

TEST(SceneDepth, FromAMillionthToInfinityIsPlacedWithinTheBudget) {
  const Display display = Small("paper-two-layer");
  View view;
  view.camera = {CameraModel::kPinhole, 640, 480, 500, 500, 320, 240, {}};
  for (const double near : {1e-6, 1.0, 1e6}) {
    const Placement placement = Place(view, near, kInfinity, display, {}, nullptr);
    EXPECT_TRUE(placement.display_from_world.allFinite());
    EXPECT_NEAR(placement.far_mm, -DepthBudgetMm(display), 1e-6);
    EXPECT_LE(placement.near_mm, DepthBudgetMm(display) + 1e-6);
    EXPECT_GT(placement.near_mm, placement.far_mm);
  }
}

TEST(Radiance, OfAHundredMillionthAndAHundredMillionIsKeptAndClampedAtThePanel) {
  const Display display = Small("paper-two-layer");
  for (const float light : {0.0F, 1e-8F, 1e8F}) {
    const LayerImages images = Distributed(Wall(-10, light), display);
    ExpectTheEyeSees(images, display, static_cast<double>(light));
    const Image<Rgb8> frame = EmitterFrame(images.slots[0][4], display, 0, PanelResponse::Srgb());
    const std::uint8_t code = light > 1 ? 255 : 0;
    EXPECT_EQ(frame(30, 20), (Rgb8{code, code, code}));
  }
}

}  // namespace
}  // namespace lamella
