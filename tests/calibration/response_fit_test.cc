// Responses of panels from photographs of a simulated camera: 14 bits with a pedestal, shot and
// read noise, shutters that are off by some per cent.
#include "calibration/response_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

using Light = std::function<double(double code)>;

struct RawCamera {
  double electrons_per_dn = 2, read_noise_dn = 3, pedestal_dn = 512;
  int num_pixels = 2000;
  double pedestal_error_dn = 0;  // of the dark frames
};
constexpr double kFullScaleDn = 16383;

// Mean and variance of a region that gets so many DN of light.
std::pair<double, double> Region(const RawCamera& camera, double light_dn, std::mt19937& random) {
  std::normal_distribution<double> normal;
  double sum = 0, squares = 0;
  for (int i = 0; i < camera.num_pixels; ++i) {
    const double sd =
        std::hypot(std::sqrt(light_dn / camera.electrons_per_dn), camera.read_noise_dn);
    const double raw = std::round(camera.pedestal_dn + light_dn + sd * normal(random));
    const double dn = std::clamp(raw, 0.0, kFullScaleDn);
    sum += dn;
    squares += dn * dn;
  }
  const double mean = sum / camera.num_pixels;
  return {mean, (squares / camera.num_pixels - mean * mean) / camera.num_pixels};
}

// 17 levels; the shutters are open 1, 8 and 64 times as long, nearly.
std::vector<FlatReading> Photographed(const Light& panel, const RawCamera& camera,
                                      std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(0.98, 1.02);
  std::vector<FlatReading> readings;
  int exposure = 0;
  for (const double factor : {1.0, 8.0, 64.0}) {
    const double white_dn = 0.8 * kFullScaleDn * factor * off(random);
    const auto [dark, dark_variance] = Region(camera, 0, random);
    for (int level = 0; level <= 16; ++level) {
      const double code = std::round(255 * level / 16.0) / 255;
      const double light_dn = white_dn * panel(code);
      if (light_dn > 0.9 * kFullScaleDn) continue;
      const auto [mean, variance] = Region(camera, light_dn, random);
      readings.push_back(
          {code, exposure, mean - dark - camera.pedestal_error_dn, variance + dark_variance});
    }
    ++exposure;
  }
  return readings;
}

Light Gamma(double black, double gamma) {
  return [=](double code) { return black + (1 - black) * std::pow(code, gamma); };
}
// A twisted cell: its transmittance is the squared sine of a voltage that a driver shapes.
Light Cell(double black) {
  return [=](double code) {
    const double sine = std::sin(std::numbers::pi / 2 * std::pow(code, 1.3));
    return black + (1 - black) * sine * sine;
  };
}

TEST(FitResponse, FindsGammaAndBlack) {
  double gamma_squares = 0, black_squares = 0;
  constexpr int kTrials = 6;
  for (std::uint32_t seed = 1; seed <= kTrials; ++seed) {
    const ResponseFit fit = FitResponse(Photographed(Gamma(8e-4, 2.3), {}, seed), "panel");
    EXPECT_EQ(fit.curve.kind, ToneCurve::Kind::kGamma);
    EXPECT_NEAR(fit.gamma, 2.3, 0.002);
    EXPECT_NEAR(fit.black, 8e-4, 1e-5);
    EXPECT_LT(fit.gamma_residual, 0.002);
    gamma_squares += std::pow((fit.gamma - 2.3) / fit.gamma_sd, 2);
    black_squares += std::pow((fit.black - 8e-4) / fit.black_sd, 2);
    EXPECT_NEAR(fit.white_light[2] / fit.white_light[0], 64, 64 * 0.05);
  }
  // No error is beyond what the deviations allow. They hold 1e-3 of flicker that this camera lacks.
  EXPECT_LT(gamma_squares / kTrials, 2);
  EXPECT_LT(black_squares / kTrials, 2);
}

TEST(FitResponse, MakesATableOfWhatIsNoGamma) {
  for (const double black : {0.0, 2e-3}) {
    const Light truth = Cell(black);
    const ResponseFit fit = FitResponse(Photographed(truth, {}, 3), "panel");
    ASSERT_EQ(fit.curve.kind, ToneCurve::Kind::kTable);
    EXPECT_EQ(fit.curve.table.size(), 33U);
    EXPECT_GT(fit.gamma_residual, 0.01);
    EXPECT_NEAR(fit.black, black, 1e-5);
    double largest = 0;
    for (int code = 0; code < 256; ++code) {
      const double light = fit.black + (1 - fit.black) * LightOfCode(fit.curve, code / 255.0);
      largest = std::max(largest, std::abs(light - truth(code / 255.0)));
    }
    EXPECT_LT(largest, 0.003);
  }
}

// As of virtual photographs: no noise at all, and nothing from a black panel.
TEST(FitResponse, TakesExactReadings) {
  std::vector<FlatReading> readings;
  for (int exposure = 0; exposure < 2; ++exposure) {
    const double factor = exposure == 0 ? 0.8 : 6.4;
    for (int level = 0; level <= 16; ++level) {
      const double code = std::round(255 * level / 16.0) / 255;
      const double light = factor * std::pow(code, 2.2);
      if (light < 0.9) readings.push_back({code, exposure, light, 0});
    }
  }
  const ResponseFit fit = FitResponse(readings, "panel");
  EXPECT_NEAR(fit.gamma, 2.2, 1e-4);
  EXPECT_NEAR(fit.black, 0, 1e-8);
}

// Its own gamma: what calibration.md has of shutters that are trusted, and of a pedestal that is
// wrong by one code.
TEST(FitResponse, DoesNotTrustShutters) {
  std::vector<FlatReading> readings = Photographed(Gamma(1e-3, 2.2), {}, 5);
  for (FlatReading& reading : readings) {
    if (reading.exposure != 1) continue;
    reading.light *= 1.5;
    reading.variance *= 1.5 * 1.5;
  }
  const ResponseFit fit = FitResponse(readings, "panel");
  EXPECT_NEAR(fit.gamma, 2.2, 0.002);
  EXPECT_NEAR(fit.black, 1e-3, 1e-5);
}

TEST(FitResponse, KeepsAWrongPedestalSmallByLongExposures) {
  RawCamera camera;
  camera.pedestal_error_dn = 1;
  const ResponseFit fit = FitResponse(Photographed(Gamma(8e-4, 2.2), camera, 7), "panel");
  EXPECT_NEAR(fit.gamma, 2.2, 0.01);
  EXPECT_NEAR(fit.black, 8e-4, 5e-5);
}

TEST(FitResponse, RefusesWhatDoesNotSuffice) {
  const auto refusal = [](std::vector<FlatReading> readings) {
    try {
      FitResponse(readings, "layer 1 modulator");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::vector<FlatReading> all = Photographed(Gamma(1e-3, 2.2), {}, 5);
  std::vector<FlatReading> some = all;
  std::erase_if(some, [](const FlatReading& r) { return r.code == 1; });
  EXPECT_THAT(refusal(some), HasSubstr("layer 1 modulator: its response needs black, white"));
  some = all;
  std::erase_if(some, [](const FlatReading& r) { return r.exposure == 2 && r.code > 0; });
  EXPECT_THAT(refusal({}), HasSubstr("needs black, white"));
  for (FlatReading& reading : some) {
    if (reading.exposure == 2) reading.light = 0;
  }
  EXPECT_THAT(refusal(some), HasSubstr("exposure 3 shares no level"));
}

}  // namespace
}  // namespace lamella
