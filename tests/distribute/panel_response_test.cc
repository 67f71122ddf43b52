#include "distribute/panel_response.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lightfield/color.h"

namespace lamella {
namespace {

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

}  // namespace
}  // namespace lamella
