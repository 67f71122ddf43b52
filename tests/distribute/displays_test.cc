#include "distribute/displays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

TEST(FindDisplay, KnowsThePaperConfigurations) {
  EXPECT_THAT(DisplayNames(),
              ::testing::ElementsAre("paper-one-layer", "paper-two-layer", "paper-two-layer-half"));
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
