#include "lightfield/color.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

namespace lamella {
namespace {

TEST(Color, CodesAreTheRoundedFormulaForEveryFloat) {
  const auto of_formula = [](float linear) {
    return static_cast<int>(std::lround(LinearToSrgb(linear) * 255.0F));
  };
  for (std::uint32_t bits = 0x30000000; bits < 0x3f800000; bits += 37) {
    const float linear = std::bit_cast<float>(bits);
    ASSERT_EQ(LinearToSrgb8(linear), of_formula(linear)) << linear;
  }
}

TEST(Color, CodesOfWhatIsNoLightAreTheNearest) {
  EXPECT_EQ(LinearToSrgb8(0), 0);
  EXPECT_EQ(LinearToSrgb8(-1), 0);
  EXPECT_EQ(LinearToSrgb8(std::nanf("")), 0);
  EXPECT_EQ(LinearToSrgb8(1e-30F), 0);
  EXPECT_EQ(LinearToSrgb8(1), 255);
  EXPECT_EQ(LinearToSrgb8(INFINITY), 255);
}

}  // namespace
}  // namespace lamella
