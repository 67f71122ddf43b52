// What a report shows beside the numbers: residuals over panels, rays over places, the next view.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/calibrate.h"
#include "tests/calibration/standard_scene.h"

namespace lamella {
namespace {

using testing::Contains;
using testing::Field;

SceneOptions FewPhotographs() {
  SceneOptions options;
  options.columns = 9;
  options.rows = 6;
  return options;
}

const ResidualMap& MapOf(const CalibrationReport& report, const PanelId& panel) {
  return *std::find_if(report.residuals.begin(), report.residuals.end(),
                       [&](const ResidualMap& map) { return map.panel == panel; });
}

TEST(ResidualMaps, AreInThePanelsPixelsWhicheverWayTheCameraIsTurned) {
  const StandardScene scene = MakeStandardScene(FewPhotographs());
  Observations observations = Noisy(scene.exact, 0.05, 4);
  // A piece of one panel is shown 0.5 of its px to the right of where it should be.
  const PanelId panel{1, PanelId::kEmitter};
  for (PanelPhoto& photo : observations.photos) {
    if (photo.panel != panel) continue;
    for (Observation& point : photo.points) {
      if (point.panel_px.x() > 240 || point.panel_px.y() > 216) continue;
      const auto at = SeenAt(scene.truth.layers[1], PanelId::kEmitter, scene.camera,
                             scene.camera_from_display[static_cast<std::size_t>(photo.view)],
                             point.panel_px + Eigen::Vector2d(0.5, 0));
      ASSERT_TRUE(at);
      point.image_px +=
          *at - *SeenAt(scene.truth.layers[1], PanelId::kEmitter, scene.camera,
                        scene.camera_from_display[static_cast<std::size_t>(photo.view)],
                        point.panel_px);
      point.covariance_px2 *= 100;  // so that it does not draw the panel
    }
  }
  const CalibrationReport report = Calibrate(observations, scene.design);
  const ResidualMap& map = MapOf(report, panel);
  ASSERT_EQ(map.cells.size(), 40U);
  EXPECT_EQ(map.views.size(), 12U);
  ASSERT_GE(map.At(0, 0).num_points, 9);
  EXPECT_NEAR(map.At(0, 0).mean_px.x(), 0.5, 0.05);
  EXPECT_NEAR(map.At(0, 0).mean_px.y(), 0, 0.05);
  EXPECT_LT(map.At(5, 3).mean_px.norm(), 0.03);
  int num_points = 0;
  for (const ResidualCell& cell : map.cells) num_points += cell.num_points;
  EXPECT_NEAR(num_points, 12 * 54, 24);
}

TEST(Deviations, AreThoseOfTheParametersByNameAndUnit) {
  const StandardScene scene = MakeStandardScene(FewPhotographs());
  const CalibrationReport report = Calibrate(Noisy(scene.exact, 0.1, 4), scene.design);
  ASSERT_FALSE(report.deviations.empty());
  for (const ParameterDeviation& deviation : report.deviations) {
    EXPECT_GT(deviation.sd, 0) << deviation.name;
    if (deviation.name != "layer 1 gap") continue;
    EXPECT_EQ(deviation.unit, "mm");
    const double error = report.calibration.layers[1].gap_mm - scene.truth.layers[1].gap_mm;
    EXPECT_LT(std::abs(error), 4 * deviation.sd);
    EXPECT_LT(deviation.sd, 0.02);
  }
  EXPECT_THAT(report.deviations, Contains(Field(&ParameterDeviation::name, "layer 1 gap")));
  ASSERT_EQ(report.probed.size(), report.rays.sd_px.size());
  double sum = 0, most = 0;
  for (const double sd : report.rays.sd_px) {
    sum += sd * sd;
    most = std::max(most, sd);
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(report.rays.sd_px.size())), report.rays.rms_sd_px,
              1e-9);
  EXPECT_EQ(most, report.rays.max_sd_px);
}

// What taking the photograph that is advised does to the deviation is what was foretold, and more
// than one from where there were views already.
TEST(NextView, IsWorthWhatItForetells) {
  SceneOptions options = FewPhotographs();
  options.num_views = 6;
  options.one_side_deg = 20;
  options.yaw_deg = options.pitch_deg = 5;
  options.misalign_mm = options.misalign_deg = 0;
  const StandardScene scene = MakeStandardScene(options);
  const CalibrationReport before = Calibrate(Noisy(scene.exact, 0.1, 4), scene.design);
  ASSERT_TRUE(before.next_view);
  EXPECT_LT(before.next_view->right_deg, 0);  // all views are from the right
  EXPECT_NEAR(before.next_view->rms_sd_px, before.rays.rms_sd_px, 0.1 * before.rays.rms_sd_px);

  options.num_views = 1;
  options.one_side_deg = before.next_view->right_deg;
  options.yaw_deg = options.pitch_deg = 0;
  options.near_mm = options.far_mm = before.next_view->distance_mm;
  Observations more = scene.exact;
  for (PanelPhoto photo : MakeStandardScene(options).exact.photos) {
    photo.view = 6;
    photo.photo = "next " + photo.photo;
    more.photos.push_back(std::move(photo));
  }
  const CalibrationReport after = Calibrate(Noisy(more, 0.1, 4), scene.design);
  EXPECT_NEAR(after.rays.rms_sd_px, before.next_view->next_rms_sd_px,
              0.3 * before.next_view->next_rms_sd_px);
  EXPECT_LT(after.rays.rms_sd_px, 0.8 * before.rays.rms_sd_px);
}

// Also where the photographs leave directions open, which is when advice is needed most.
TEST(NextView, IsToldWhereTheDisplayIsNotDetermined) {
  SceneOptions options = FewPhotographs();
  options.num_views = 4;
  options.yaw_deg = options.pitch_deg = 0;
  const StandardScene scene = MakeStandardScene(options);
  const CalibrationReport report = Calibrate(Noisy(scene.exact, 0.1, 4), scene.design);
  EXPECT_FALSE(report.accepted());
  ASSERT_TRUE(report.next_view);
  EXPECT_GE(std::abs(report.next_view->right_deg), 20);
  EXPECT_LT(report.next_view->next_rms_sd_px, 0.5 * report.next_view->rms_sd_px);
}

}  // namespace
}  // namespace lamella
