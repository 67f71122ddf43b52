#include "distribute/panel_response.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "lightfield/color.h"
#include "lightfield/error.h"

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

// What two unlike panels show together is the scene's light, times what both can show of white.
TEST(PanelResponse, MakesCalibratedLayersAlike) {
  Display display;
  display.name = "unlike";
  display.layers.resize(2);
  Calibration calibration = DesignCalibration(display);
  Photometry& back = calibration.layers[0].emitter.photometry;
  back.primaries << 0.9, 0.05, 0, 0.02, 0.8, 0.05, 0, 0.04, 0.7;
  back.black = 0.004;
  back.curve = {ToneCurve::Kind::kGamma, 2.4, {}};
  calibration.layers[0].gain = 0.4;
  calibration.layers[1].gain = 0.55;
  calibration.layers[1].emitter.photometry.curve = {ToneCurve::Kind::kTable, 0, {0, 0.1, 0.4, 1}};
  const double white = CommonWhite(calibration);
  EXPECT_GT(white, 0.2);
  EXPECT_LT(white, 0.4 * 0.75);
  const Rgb light{0.6F, 0.35F, 0.8F};
  for (int layer = 0; layer < 2; ++layer) {
    const LayerCalibration& of = calibration.layers[static_cast<std::size_t>(layer)];
    const Rgb8 codes = PanelResponse::Of(calibration, layer).Codes(light);
    const Photometry& photometry = of.emitter.photometry;
    const auto level = [&](std::uint8_t code) {
      return photometry.black +
             (1 - photometry.black) * LightOfCode(photometry.curve, code / 255.0);
    };
    const Eigen::Vector3d seen = of.gain * photometry.primaries *
                                 Eigen::Vector3d(level(codes.r), level(codes.g), level(codes.b)) /
                                 white;
    EXPECT_NEAR(seen.x(), 0.6, 0.008);
    EXPECT_NEAR(seen.y(), 0.35, 0.008);
    EXPECT_NEAR(seen.z(), 0.8, 0.008);
  }
  EXPECT_NEAR(CommonWhite(DesignCalibration(display)), 0.5, 1e-12);
  back.primaries.setOnes();
  EXPECT_THROW(CommonWhite(calibration), Error);
}

TEST(PanelResponse, EvensOutPanels) {
  Display display;
  display.name = "uneven";
  display.layers.resize(1);
  Calibration calibration = DesignCalibration(display);
  Photometry& photometry = calibration.layers[0].emitter.photometry;
  photometry.curve = {ToneCurve::Kind::kGamma, 2.2, {}};
  photometry.evenness = {3, 2, {0.8, 1, 1.1, 0.9, 1.05, 1.15}};
  EXPECT_NEAR(CommonWhite(calibration), 0.8, 1e-12);
  const PanelResponse response = PanelResponse::Of(calibration, 0);
  // In the middles of the cells as they are given, and half-way between them.
  const std::pair<Eigen::Vector2d, double> places[] = {{{1 / 6.0, 0.25}, 0.8}, {{0.5, 0.25}, 1},
                                                       {{0.5, 0.75}, 1.05},    {{1, 0.75}, 1.15},
                                                       {{2 / 6.0, 0.25}, 0.9}, {{0.5, 0.5}, 1.025}};
  for (const auto& [place, gain] : places) {
    const Rgb8 code = response.Codes({0.5F, 0.5F, 1}, place.x(), place.y());
    EXPECT_NEAR(gain * std::pow(code.r / 255.0, 2.2), 0.8 * 0.5, 0.004);
    EXPECT_NEAR(gain * std::pow(code.b / 255.0, 2.2), 0.8, 0.005);
  }
}

}  // namespace
}  // namespace lamella
