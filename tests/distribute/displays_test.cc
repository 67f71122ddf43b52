#include "distribute/displays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

TEST(FindDisplay, KnowsThePaperConfigurationsAndADepthFusedDisplay) {
  EXPECT_THAT(DisplayNames(),
              ::testing::ElementsAre("depth-fused", "paper-one-layer", "paper-two-layer",
                                     "paper-two-layer-half", "paper-varifocal"));
  for (const std::string& name : DisplayNames()) EXPECT_EQ(FindDisplay(name).name, name);
}

TEST(FindDisplay, HasTheRayCountsOfThePaper) {
  const auto rays = [](const Display& d) {
    double sum = 0;
    for (const Layer& layer : d.layers) {
      sum += std::pow(SlotsPerAxis(layer), 2) * d.emitter_columns() * d.emitter_rows();
    }
    return sum;
  };
  const double one = rays(FindDisplay("paper-one-layer"));
  EXPECT_DOUBLE_EQ(rays(FindDisplay("paper-two-layer")) / one, 2);
  EXPECT_DOUBLE_EQ(rays(FindDisplay("paper-two-layer-half")) / one, 0.5);
}

TEST(FindDisplay, KeepsFieldOfViewAndLatticeInTheHalfConfiguration) {
  const Display full = FindDisplay("paper-two-layer"), half = FindDisplay("paper-two-layer-half");
  EXPECT_NEAR(FieldOfViewDeg(full, full.layers[0]), 21.16, 0.01);
  EXPECT_DOUBLE_EQ(FieldOfViewDeg(half, half.layers[0]), FieldOfViewDeg(full, full.layers[0]));
  EXPECT_DOUBLE_EQ(LatticePitchMm(half, half.layers[0]), LatticePitchMm(full, full.layers[0]));
  EXPECT_DOUBLE_EQ(DepthBudgetMm(full), 20);
  EXPECT_DOUBLE_EQ(DepthBudgetMm(half), 10);
  EXPECT_DOUBLE_EQ(DepthBudgetMm(FindDisplay("paper-one-layer")), 10);
  EXPECT_TRUE(full.layers[0].mirror_x);
  EXPECT_FALSE(full.layers[1].mirror_x);
}

TEST(FindDisplay, HasTheVarifocalPrototypeOfThePaper) {
  const Display display = FindDisplay("paper-varifocal");
  ASSERT_EQ(display.layers.size(), 24U);
  EXPECT_DOUBLE_EQ(display.layers[0].position_mm, -94);
  EXPECT_DOUBLE_EQ(display.layers[23].position_mm, 94);
  EXPECT_NEAR(display.layers[12].position_mm - display.layers[11].position_mm, 8.17, 0.005);
  const Layer& layer = display.layers[7];
  EXPECT_NEAR(display.width_mm(), 167, 1e-9);
  EXPECT_NEAR(display.height_mm(), 125, 0.5);
  EXPECT_NEAR(layer.d0_mm, 2.92, 0.005);
  EXPECT_NEAR(FieldOfViewDeg(display, layer), 19, 1e-9);
  EXPECT_NEAR(LatticePitchMm(display, layer), 2.120, 0.0005);
  EXPECT_NEAR(SharpRangeMm(display, layer), 38, 0.05);
  EXPECT_NEAR(GuardShare(layer), 0.754, 0.0005);
  EXPECT_DOUBLE_EQ(Brightness(display, layer), 1.0 / 24);
  EXPECT_EQ(DirectionsPerAxis(layer), 6);
  EXPECT_DOUBLE_EQ(display.border_offset_mm, 0);  // lenses are sharpest where they are
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
}

TEST(FindDisplay, OffersTheNearestName) {
  const auto refusal = [](const std::string& name) -> std::string {
    try {
      FindDisplay(name);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal("paper-two-layr"), HasSubstr("did you mean \"paper-two-layer\"?"));
  EXPECT_THAT(refusal("./absent.toml"), HasSubstr("no file \"./absent.toml\""));
  EXPECT_THAT(refusal(""), HasSubstr("no display is called \"\""));
}

}  // namespace
}  // namespace lamella
