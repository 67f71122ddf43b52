#include "calibration/camera_response.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

using Curve = std::function<double(double light)>;

double Srgb(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}
// Contrast as cameras add it to sRGB: an S over its numbers.
double Contrasty(double light) {
  const double number = Srgb(light);
  return number + 0.35 * number * (1 - number) * (2 * number - 1);
}

// Seventeen levels of panels with gammas of 2.2 and 1.9, of 8 bits, at 1, 8 and 64 times an
// exposure whose white has 80 % of full scale; longer shutters are off by what is given.
std::vector<NumberReading> Photographed(const Curve& curve, double off) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  std::vector<NumberReading> readings;
  int patch = 0;
  for (const double gamma : {2.2, 1.9, 2.4, 2.0}) {
    for (int level = 0; level <= 16; ++level, ++patch) {
      const double light = 1e-3 + (1 - 1e-3) * std::pow(level / 16.0, gamma);
      for (const double exposure : {1.0, 8.0, 64.0}) {
        const double real = 0.8 * light * exposure * (exposure > 1 ? 1 + off : 1);
        double sum = 0;
        constexpr int kPixels = 500;
        for (int i = 0; i < kPixels; ++i) {
          const double noisy = real + 0.006 * std::sqrt(real + 1e-4) * noise(random);
          sum += std::round(255 * curve(std::clamp(noisy, 0.0, 1.0))) / 255;
        }
        readings.push_back({patch, exposure, sum / kPixels, 1e-8});
      }
    }
  }
  return readings;
}

// The exponent that a panel's gamma would be wrong by, from 2 % to 70 % of white.
double ExponentError(const CameraResponse& response, const Curve& curve) {
  const double dark = response.LightOf(curve(0.02)), bright = response.LightOf(curve(0.7));
  return std::log(bright / dark) / std::log(0.7 / 0.02) - 1;
}

TEST(EstimateCameraResponse, FindsToneCurves) {
  for (const Curve& curve : {Curve(Srgb), Curve(Contrasty), Curve([](double l) { return l; })}) {
    const CameraResponse response = EstimateCameraResponse(Photographed(curve, 0), "photos");
    EXPECT_LT(response.rms, 0.02);
    EXPECT_NEAR(ExponentError(response, curve), 0, 0.01);
    const double scale = response.LightOf(curve(0.3)) / 0.3;
    for (const double light : {0.02, 0.1, 0.5, 0.8}) {
      EXPECT_NEAR(response.LightOf(curve(light)) / scale, light, 0.03 * light);
    }
    EXPECT_EQ(response.LightOf(0), 0);
  }
}

// What linear photographs are spared.
TEST(EstimateCameraResponse, TakesShuttersAtTheirWord) {
  const double error =
      ExponentError(EstimateCameraResponse(Photographed(Srgb, 0.02), "photos"), Srgb);
  EXPECT_GT(std::abs(error), 0.002);
  EXPECT_LT(std::abs(error), 0.015);
}

TEST(EstimateCameraResponse, RefusesWhatTellsNothing) {
  const auto refusal = [](const std::vector<NumberReading>& readings) {
    try {
      EstimateCameraResponse(readings, "photos");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  std::vector<NumberReading> readings = Photographed(Srgb, 0);
  std::erase_if(readings, [](const NumberReading& r) { return r.exposure > 1; });
  EXPECT_THAT(refusal(readings), HasSubstr("photos: 0 levels are seen at two exposures"));
  readings = Photographed(Srgb, 0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0.1, 0.9);
  for (NumberReading& reading : readings) reading.number = any(random);
  EXPECT_NE(refusal(readings), "accepted");
}

}  // namespace
}  // namespace lamella
