#include "calibration/vignetting.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "tests/calibration/degree.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

constexpr int kCells = kGainColumns * kGainRows;

struct Truth {
  std::vector<double> falloff = {1.7, 0.6};
  std::vector<std::vector<double>> gains;
};

Truth MakeTruth() {
  Truth truth;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> share(0.85, 1.1);
  for (int layer = 0; layer < 2; ++layer) {
    truth.gains.emplace_back();
    double sum = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      truth.gains.back().push_back(share(random));
      sum += truth.gains.back().back();
    }
    for (double& gain : truth.gains.back()) gain *= kCells / sum;
  }
  return truth;
}

// A panel of 600 x 340 mm, a camera 1 m away that looks at its middle, of which a picture's corner
// is 0.36 from the middle in slopes.
struct View {
  double yaw_deg, pitch_deg, roll_deg;
};

std::vector<WhiteReading> Photographed(const Truth& truth, const std::vector<View>& views,
                                       double noise, unsigned seed = 4) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<WhiteReading> readings;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double yaw = views[v].yaw_deg * kDegree, pitch = views[v].pitch_deg * kDegree;
    const double eye[3] = {1000 * std::sin(yaw) * std::cos(pitch), 1000 * std::sin(pitch),
                           1000 * std::cos(yaw) * std::cos(pitch)};
    for (int layer = 0; layer < 2; ++layer) {
      for (int cell = 0; cell < kCells; ++cell) {
        const int column = cell % kGainColumns, row = cell / kGainColumns;
        const double x = ((column + 0.5) / kGainColumns - 0.5) * 600;
        const double y = (0.5 - (row + 0.5) / kGainRows) * 340;
        const double to[3] = {eye[0] - x, eye[1] - y, eye[2]};
        const double distance = std::hypot(to[0], to[1], to[2]);
        // The angle to the optical axis, which goes through the panel's middle.
        const double along = (to[0] * eye[0] + to[1] * eye[1] + to[2] * eye[2]) / 1000;
        const double slope2 = (distance * distance - along * along) / (along * along);
        const double radius2 = slope2 / (0.36 * 0.36);
        const double cosine = to[2] / distance;
        const double lens = (1 - 0.25 * radius2) / std::pow(1 + slope2, 2);
        const auto l = static_cast<std::size_t>(layer);
        const double light = 0.6 * truth.gains[l][static_cast<std::size_t>(cell)] * lens *
                             std::pow(cosine, truth.falloff[l]) * (1 + noise * normal(random));
        readings.push_back({layer, static_cast<int>(v), x / 600 + 0.5, 0.5 - y / 340, light,
                            std::pow(noise * light, 2), radius2, cosine});
      }
    }
  }
  return readings;
}

const std::vector<View> kViews = {{0, 0, 0}, {22, 5, 0}, {-20, 12, 0}, {5, -18, 0}, {-8, -6, 0}};

TEST(FitEvenness, TellsTheLensFromTheDisplay) {
  const Truth truth = MakeTruth();
  const Evenness fit = FitEvenness(Photographed(truth, kViews, 1e-3), 2, "d");
  for (std::size_t l = 0; l < 2; ++l) {
    EXPECT_NEAR(fit.layers[l].falloff, truth.falloff[l], 0.03);
    EXPECT_NEAR(fit.layers[l].falloff, truth.falloff[l], 4 * fit.layers[l].falloff_sd);
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      EXPECT_NEAR(fit.layers[l].gains.gains[cell], truth.gains[l][cell], 0.005) << cell;
    }
  }
  EXPECT_LT(fit.rms, 0.002);
  EXPECT_NEAR(VignettingAt(fit, 0.5), (1 - 0.125) / std::pow(1 + 0.5 * 0.36 * 0.36, 2), 0.01);
}

// Photographs whose light differs as a whole (a lamp, a shutter) or from the middle to the corners.
TEST(FitEvenness, SaysHowUncertainTheFallOffIsWhereWholePhotographsAreOff) {
  const Truth truth = MakeTruth();
  constexpr int kTrials = 60;
  for (const bool radial : {false, true}) {
    for (const std::size_t num_views : {4U, 5U}) {
      const std::vector<View> views(kViews.begin(), kViews.begin() + num_views);
      double squares = 0, stated = 0;
      for (unsigned trial = 0; trial < kTrials; ++trial) {
        std::vector<WhiteReading> readings = Photographed(truth, views, 3e-4, trial);
        std::mt19937 random(1000 + trial);
        std::normal_distribution<double> off(0, radial ? 1e-3 : 5e-4);
        std::vector<double> shared(views.size());
        for (double& value : shared) value = off(random);
        for (WhiteReading& reading : readings) {
          const double share = radial ? reading.radius2 : 1;
          reading.light *= 1 + share * shared[static_cast<std::size_t>(reading.view)];
        }
        const Evenness fit = FitEvenness(readings, 2, "d");
        for (std::size_t l = 0; l < 2; ++l) {
          squares += std::pow(fit.layers[l].falloff - truth.falloff[l], 2);
          stated += std::pow(fit.layers[l].falloff_sd, 2);
        }
      }
      const double ratio = std::sqrt(stated / squares);
      EXPECT_GT(ratio, 0.8) << radial << " " << num_views << " "
                            << std::sqrt(squares / kTrials / 2);
      EXPECT_LT(ratio, 1.6) << radial << " " << num_views;
    }
  }
}

TEST(FitEvenness, RefusesDirectionsThatAreAlike) {
  const Truth truth = MakeTruth();
  const auto refusal = [&](const std::vector<View>& views) {
    try {
      FitEvenness(Photographed(truth, views, 1e-3), 2, "desk");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal({{0, 0, 0}, {20, 0, 0}}), HasSubstr("desk: layer 0's white is seen from 2"));
  EXPECT_THAT(refusal({{0, 0, 0}, {0.5, 0, 0}, {-0.5, 0, 0}}), HasSubstr("fall-off is known to"));
  EXPECT_EQ(refusal(kViews), "accepted");
}

}  // namespace
}  // namespace lamella
