// What residuals say against a calibration, each in a scene that is known exactly.
#include "calibration/gates.h"

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calibration/standard_scene.h"

namespace lamella {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SceneOptions Scene() {
  SceneOptions options;
  options.columns = 11;
  options.rows = 7;
  return options;
}

std::string Said(const CalibrationReport& report) {
  std::string text;
  for (const Weakness& weakness : report.failures)
    text += weakness.lost + " | " + weakness.cure + "\n";
  return text;
}

CalibrationReport Calibrated(const std::function<void(Observations&)>& edit) {
  const StandardScene scene = MakeStandardScene(Scene());
  Observations observations = Noisy(scene.exact, 0.05, 5);
  edit(observations);
  return Calibrate(observations, scene.design);
}

void AddNoise(PanelPhoto& photo, double sd_px) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, sd_px);
  for (Observation& point : photo.points) {
    const double x = normal(random), y = normal(random);
    point.image_px += Eigen::Vector2d(x, y);
  }
}

TEST(Gates, PassCleanPhotographs) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    SceneOptions options = Scene();
    options.seed = seed;
    const StandardScene scene = MakeStandardScene(options);
    EXPECT_EQ(Said(Calibrate(Noisy(scene.exact, 0.05, seed), scene.design)), "");
  }
}

TEST(Gates, NoticeAViewOfLargerErrors) {
  const CalibrationReport report = Calibrated([](Observations& observations) {
    for (PanelPhoto& photo : observations.photos) {
      if (photo.view == 4) AddNoise(photo, 0.06);
    }
  });
  EXPECT_FALSE(report.accepted());
  EXPECT_THAT(Said(report),
              AllOf(HasSubstr("view 5 fits with"), HasSubstr("take position 5 again")));
}

TEST(Gates, NoticeAPanelOfLargerErrors) {
  const CalibrationReport report = Calibrated([](Observations& observations) {
    for (PanelPhoto& photo : observations.photos) {
      if (photo.panel == PanelId{0, PanelId::kEmitter}) AddNoise(photo, 0.06);
    }
  });
  EXPECT_FALSE(report.accepted());
  EXPECT_THAT(Said(report),
              AllOf(HasSubstr("layer 0 emitter fits with"), HasSubstr("photographs again")));
}

// A dent where the model is smooth: a part of the panel is elsewhere, wherever it is seen from.
TEST(Gates, NoticeADentInAPanel) {
  const StandardScene scene = MakeStandardScene(Scene());
  Observations observations = Noisy(scene.exact, 0.05, 5);
  for (PanelPhoto& photo : observations.photos) {
    if (photo.panel != PanelId{1, PanelId::kEmitter}) continue;
    const auto seen = [&](const Eigen::Vector2d& panel_px) {
      return *SeenAt(scene.truth.layers[1], PanelId::kEmitter, scene.camera,
                     scene.camera_from_display[static_cast<std::size_t>(photo.view)], panel_px);
    };
    for (Observation& point : photo.points) {
      const Eigen::Vector2d away = point.panel_px - Eigen::Vector2d(480, 300);
      const double dent_px = 0.15 * std::exp(-away.squaredNorm() / (2 * 150.0 * 150.0));
      point.image_px += seen(point.panel_px + Eigen::Vector2d(dent_px, 0)) - seen(point.panel_px);
    }
  }
  const CalibrationReport report = Calibrate(observations, scene.design);
  EXPECT_FALSE(report.accepted());
  EXPECT_THAT(Said(report), AllOf(HasSubstr("rays through a part of layer 1 emitter"),
                                  HasSubstr("--mode precise")));
}

TEST(Gates, NoticePhotographsThatSlip) {
  const CalibrationReport report =
      Calibrated([](Observations& observations) { AddSlips(observations, 0.12, 3); });
  EXPECT_FALSE(report.accepted());
  EXPECT_THAT(Said(report), AllOf(HasSubstr("gaps and offsets"), HasSubstr("fix the camera")));
}

}  // namespace
}  // namespace lamella
