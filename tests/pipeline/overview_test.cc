#include "pipeline/overview.h"

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/color.h"

namespace lamella {
namespace {

class OverviewOf : public testing::TestWithParam<std::pair<int, int>> {};

// Whatever a photograph's shape, no pane is wider than twice its height, so that the file can be
// written and looked at.
TEST_P(OverviewOf, AnyShapeIsNoWiderThanItsPanesMayBe) {
  const auto [width, height] = GetParam();
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 48;
  display.height_px = 24;
  LayerImages layers;
  layers.slots.resize(2);
  for (auto& slots : layers.slots) {
    slots.resize(9);
    for (EmitterImage& slot : slots) {
      slot = {Image<Rgb>(48, 24, {0.2F, 0.2F, 0.2F}), Image<float>(48, 24, 1.0F)};
    }
  }
  const Image<Rgb> photograph(width, height, {0.5F, 0.1F, 0.1F});
  const DepthMap depth{Image<float>(width, height), Image<float>(width, height)};  // all unknown
  Eye eye;
  eye.pixel_mm = display.pitch_mm;
  eye.left_mm = -1e6;  // a picture that no panel stands behind
  eye.width = width;
  eye.height = height;
  const Image<Rgb8> seen(width, height, {9, 9, 9});
  const Image<Rgb8> overview =
      Overview(photograph.span(), depth, OpenImages(layers), display, eye, seen.span());
  EXPECT_EQ(overview.height(), 270);
  EXPECT_LE(overview.width(), 5 * 540 + 4 * 6);
  EXPECT_EQ(overview(0, 0).r, LinearToSrgb8(0.5F));
}
INSTANTIATE_TEST_SUITE_P(Shapes, OverviewOf,
                         testing::Values(std::pair(1, 1), std::pair(30000, 1), std::pair(1, 3000),
                                         std::pair(40, 30)));

}  // namespace
}  // namespace lamella
