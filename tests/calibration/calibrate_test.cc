// Displays calibrated from photographs of a scene that is known exactly (standard_scene.h).
#include "calibration/calibrate.h"

#include <algorithm>
#include <functional>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "tests/calibration/standard_scene.h"

namespace lamella {
namespace {

using testing::HasSubstr;

SceneOptions Small() {
  SceneOptions options;
  options.columns = 9;
  options.rows = 6;
  options.misalign_mm = 20;
  options.misalign_deg = 5;
  return options;
}

RayDifference RayError(const Calibration& a, const Calibration& b, const StandardScene& scene) {
  const Structure structure = StructureOf(scene.exact, scene.design);
  const auto rays = RaysToProbe(structure, {});
  return CompareRays(PixelsOfRays(a, structure.reference, rays),
                     PixelsOfRays(b, structure.reference, rays));
}

std::string Lost(const CalibrationReport& report) {
  std::string lost;
  for (const Weakness& weakness : report.failures) lost += weakness.lost + "\n";
  for (const Weakness& weakness : report.warnings) lost += weakness.lost + "\n";
  return lost;
}

std::string Refusal(const Observations& observations, const Calibration& design) {
  try {
    Calibrate(observations, design);
  } catch (const Error& error) {
    EXPECT_NE(error.code(), ExitCode::kBug);
    return error.what();
  }
  return "";
}

void KeepPhotos(Observations& observations, const std::function<bool(const PanelPhoto&)>& wanted) {
  std::erase_if(observations.photos, [&](const PanelPhoto& photo) { return !wanted(photo); });
}

void KeepPoints(Observations& observations, const std::function<bool(const Observation&)>& wanted) {
  for (PanelPhoto& photo : observations.photos) {
    std::erase_if(photo.points, [&](const Observation& point) { return !wanted(point); });
  }
}

// The display is found from 20 mm, 5 degrees and half a per cent away, whatever the focal guess.
TEST(Calibrate, FindsAMisalignedDisplayFromExactPoints) {
  SceneOptions options = Small();
  for (const double focal_px : {0.0, 4900.0, 10500.0}) {
    options.seed += 1;
    options.scale = focal_px == 0 ? 0.005 : 0;
    StandardScene scene = MakeStandardScene(options);
    scene.exact.cameras[0].focal_px = focal_px;
    const CalibrationReport report = Calibrate(scene.exact, scene.design);
    EXPECT_TRUE(report.accepted()) << Lost(report);
    EXPECT_LT(RayError(report.calibration, scene.truth, scene).max_px, 1e-5) << focal_px;
    EXPECT_NEAR(report.cameras[0].fx, scene.camera.fx, 1e-3);
    EXPECT_NEAR(report.calibration.layers[1].gap_mm, scene.truth.layers[1].gap_mm, 1e-5);
    EXPECT_LT(
        (report.camera_from_display[3].translation - (scene.camera_from_display[3]).translation)
            .norm(),
        1e-3);
    EXPECT_EQ(report.reference, (PanelId{1, PanelId::kModulator}));
  }
}

// Pixels of the layer's other panel from the point that a photograph shows to that panel's nearest
// edge; negative: beyond it. Along the line of sight, opposite to the code under test.
double FromOtherEdge(const StandardScene& scene, const PanelPhoto& photo,
                     const Observation& point) {
  const LayerCalibration& layer = scene.truth.layers[static_cast<std::size_t>(photo.panel.layer)];
  const bool emitter = photo.panel.role == PanelId::kEmitter;
  const Rigid& camera_from_display =
      scene.camera_from_display[static_cast<std::size_t>(photo.view)];
  const auto hit = LayerSights(layer).Seen(
      Centre(camera_from_display),
      camera_from_display.rotation.inverse() * *Unproject(scene.camera, point.image_px));
  const Eigen::Vector2d at = emitter ? hit->modulator : hit->emitter;
  const PanelCalibration& other = emitter ? *layer.modulator : layer.emitter;
  return std::min({at.x(), other.width_px - at.x(), at.y(), other.height_px - at.y()});
}

// Panels 20 mm (64 px) apart: where the edge of one cuts what surrounds a corner of the other, the
// corner is found elsewhere, whatever the position. Such corners neither count nor speak against
// those that do.
TEST(Calibrate, LeavesOutCornersThatThePanelBeforeOrBehindCuts) {
  SceneOptions options;
  options.misalign_mm = 20;
  options.misalign_deg = 5;
  options.seed = 7;
  const StandardScene scene = MakeStandardScene(options);
  Observations observations = Noisy(scene.exact, 0.02, 4);
  int num_cut = 0;
  for (PanelPhoto& photo : observations.photos) {
    std::erase_if(photo.points, [&](Observation& point) {
      const double away_px = FromOtherEdge(scene, photo, point);
      const bool cut = away_px > 1 && away_px < 7;
      if (cut) point.image_px.y() += 0.2;
      num_cut += cut;
      return away_px < 0;  // there is no light
    });
  }
  ASSERT_GT(num_cut, 24);
  const CalibrationReport report = Calibrate(observations, scene.design);
  EXPECT_TRUE(report.accepted()) << Lost(report);
  EXPECT_NEAR(report.chi2, 1, 0.06);
  EXPECT_LT(RayError(report.calibration, scene.truth, scene).rms_px, 2 * report.rays.rms_sd_px);
  EXPECT_THAT(report.at_edges, testing::Contains(HasSubstr("of an edge of layer")));
}

TEST(Calibrate, StatesItsErrorUnderNoise) {
  const StandardScene scene = MakeStandardScene(Small());
  const CalibrationReport report = Calibrate(Noisy(scene.exact, 0.1, 4), scene.design);
  EXPECT_TRUE(report.accepted()) << Lost(report);
  EXPECT_NEAR(report.chi2, 1, 0.06);
  EXPECT_LT(report.slip_px, 0.02);
  const double error = RayError(report.calibration, scene.truth, scene).rms_px;
  EXPECT_LT(error, 2 * report.rays.rms_sd_px);
  EXPECT_GT(error, report.rays.rms_sd_px / 3);
  for (const FitOf& panel : report.panels) EXPECT_NEAR(panel.rms_px, 0.1414, 0.01) << panel.name;
}

TEST(Calibrate, GivesTheSameBytesWhateverTheOrderOfPhotographs) {
  const StandardScene scene = MakeStandardScene(Small());
  Observations observations = Noisy(scene.exact, 0.1, 4);
  const CalibrationReport first = Calibrate(observations, scene.design);
  std::mt19937 random(3);
  std::shuffle(observations.photos.begin(), observations.photos.end(), random);
  for (PanelPhoto& photo : observations.photos) {
    std::shuffle(photo.points.begin(), photo.points.end(), random);
  }
  const CalibrationReport second = Calibrate(observations, scene.design);
  EXPECT_EQ(RayError(first.calibration, second.calibration, scene).max_px, 0);
  EXPECT_EQ(first.cameras[0].fx, second.cameras[0].fx);
}

TEST(Calibrate, FollowsTheWorldFrameOfTheDesign) {
  const StandardScene scene = MakeStandardScene(Small());
  const Observations observations = Noisy(scene.exact, 0.1, 4);
  const CalibrationReport here = Calibrate(observations, scene.design);
  const Rigid there_from_here{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, -1).normalized())),
      {300, -200, 500}};
  Calibration moved = scene.design;
  for (LayerCalibration& layer : moved.layers) {
    layer.display_from_stack = there_from_here * layer.display_from_stack;
  }
  CalibrationReport there = Calibrate(observations, moved);
  for (LayerCalibration& layer : there.calibration.layers) {
    layer.display_from_stack = Inverse(there_from_here) * layer.display_from_stack;
  }
  EXPECT_LT(RayError(here.calibration, there.calibration, scene).max_px, 1e-9);
}

TEST(Calibrate, LeavesOutWrongPhotographsByName) {
  const StandardScene scene = MakeStandardScene(Small());
  Observations observations = Noisy(scene.exact, 0.1, 4);
  std::swap(observations.photos[4].points, observations.photos[20].points);  // file names swapped
  for (Observation& point : observations.photos[30].points) point.image_px.x() += 3;  // moved
  std::mt19937 random(3);
  std::normal_distribution<double> blur(0, 1);
  for (Observation& point : observations.photos[42].points) {
    point.image_px += Eigen::Vector2d(blur(random), blur(random));
  }
  const CalibrationReport report = Calibrate(observations, scene.design);
  EXPECT_TRUE(report.accepted()) << Lost(report);
  ASSERT_EQ(report.rejected.size(), 4U) << testing::PrintToString(report.rejected);
  EXPECT_LT(RayError(report.calibration, scene.truth, scene).rms_px, 0.03);
  const std::string all = testing::PrintToString(report.rejected);
  for (const std::size_t i : {4U, 20U, 30U, 42U}) {
    EXPECT_THAT(all, HasSubstr(observations.photos[i].photo));
  }
  EXPECT_THAT(all, HasSubstr("the camera had moved"));
}

TEST(Calibrate, SaysThatAPanelIsMirrored) {
  StandardScene scene = MakeStandardScene(Small());
  scene.design.layers[0].modulator->mirror_x = false;
  EXPECT_THAT(Refusal(scene.exact, scene.design),
              HasSubstr("layer 0 modulator is mirrored in its photographs"));
}

struct DegenerateSet {
  const char* name;
  std::function<void(SceneOptions&)> options;
  std::function<void(Observations&)> edit;
  const char* lost;
  bool refused;
};

// calibration.md section 8: what a set of photographs loses is named.
class DegenerateSets : public testing::TestWithParam<DegenerateSet> {};

TEST_P(DegenerateSets, AreRefusedOrFlaggedByName) {
  SceneOptions options = Small();
  GetParam().options(options);
  StandardScene scene = MakeStandardScene(options);
  GetParam().edit(scene.exact);
  const Observations observations = Noisy(scene.exact, 0.05, 9);
  CalibrationReport report;
  try {
    report = Calibrate(observations, scene.design);
  } catch (const Error& error) {
    EXPECT_TRUE(GetParam().refused) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(GetParam().lost));
    EXPECT_THAT(error.what(), HasSubstr("photograph"));
    return;
  }
  EXPECT_EQ(!report.accepted(), GetParam().refused) << Lost(report);
  EXPECT_THAT(Lost(report), HasSubstr(GetParam().lost));
  if (report.accepted()) {
    EXPECT_LT(RayError(report.calibration, scene.truth, scene).rms_px, 2 * report.rays.rms_sd_px);
  }
}

const auto kSameOptions = [](SceneOptions&) {};
const auto kSamePhotos = [](Observations&) {};
INSTANTIATE_TEST_SUITE_P(
    Section8, DegenerateSets,
    testing::Values(
        DegenerateSet{"OneView", [](SceneOptions& o) { o.num_views = 1; }, kSamePhotos, "focal",
                      true},
        DegenerateSet{"FrontalAtOneDistance",
                      [](SceneOptions& o) {
                        o.yaw_deg = o.pitch_deg = 0;
                        o.near_mm = o.far_mm = 1000;
                      },
                      kSamePhotos, "focal", true},
        DegenerateSet{"Frontal", [](SceneOptions& o) { o.yaw_deg = o.pitch_deg = 0; }, kSamePhotos,
                      "focal", true},
        DegenerateSet{"HardlyTilted", [](SceneOptions& o) { o.yaw_deg = o.pitch_deg = 2; },
                      kSamePhotos, "gaps", false},
        DegenerateSet{"OneSide",
                      [](SceneOptions& o) {
                        o.one_side_deg = 20;
                        o.yaw_deg = 4;
                      },
                      kSamePhotos, "rays to the left are extrapolated", false},
        DegenerateSet{
            "LeftThird",
            [](SceneOptions& o) {
              o.columns = 15;
              o.rows = 9;
            },
            [](Observations& o) { KeepPoints(o, [](auto& p) { return p.panel_px.x() < 640; }); },
            "layer 0 emitter was seen in", false},
        DegenerateSet{"CentreNinth",
                      [](SceneOptions& o) {
                        o.columns = 23;
                        o.rows = 12;
                      },
                      [](Observations& o) {
                        KeepPoints(o, [](auto& p) {
                          return std::abs(p.panel_px.x() - 960) < 320 &&
                                 std::abs(p.panel_px.y() - 540) < 180;
                        });
                      },
                      "distortion", true},
        DegenerateSet{"EmitterInOneView", kSameOptions,
                      [](Observations& o) {
                        KeepPhotos(o, [](auto& p) {
                          return p.panel != PanelId{1, PanelId::kEmitter} || p.view == 2;
                        });
                      },
                      "layer 1 emitter is in 1 views only", true},
        DegenerateSet{"DisplaysApart", kSameOptions,
                      [](Observations& o) {
                        KeepPhotos(
                            o, [](auto& p) { return (p.panel.layer == 0) == (p.view % 2 == 0); });
                      },
                      "the place of layer 0", true},
        DegenerateSet{"EmitterAndModulatorApart", kSameOptions,
                      [](Observations& o) {
                        KeepPhotos(o, [](auto& p) {
                          return (p.panel.role == PanelId::kEmitter) == (p.view % 2 == 0);
                        });
                      },
                      "emitter is lost", true},
        DegenerateSet{"OneRow", kSameOptions,
                      [](Observations& o) {
                        KeepPoints(o, [](auto& p) { return std::abs(p.panel_px.y() - 468) < 10; });
                      },
                      "off a line", true},
        DegenerateSet{"ModulatorUnseen", kSameOptions,
                      [](Observations& o) {
                        KeepPhotos(o, [](auto& p) {
                          return p.panel != PanelId{0, PanelId::kModulator};
                        });
                      },
                      "the place of layer 0 modulator", true}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace lamella
