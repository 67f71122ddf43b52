// The stage layers on a capture that the test draws: two planes seen by nine cameras, with the
// depth that they have.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "lightfield/ray_map.h"
#include "pipeline/calibration_record.h"
#include "pipeline/depth_record.h"
#include "pipeline/layers_record.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

constexpr double kFar = 3, kNear = 2, kFocal = 120;
constexpr int kCaptureWidth = 96, kCaptureHeight = 72;

// The far plane everywhere, before it a near one where X > 0.2.
bool IsNear(double x) { return x > 0.2; }

Rgb Color(double x, double y, bool near) {
  const auto wave = static_cast<float>(0.5 + 0.25 * std::sin(6 * x) * std::cos(5 * y));
  return near ? Rgb{wave, 0.1F, 0.1F} : Rgb{0.1F, wave, 0.2F};
}

struct Drawn {
  Image<Rgb> color;
  DepthMap depth;
};

Drawn Draw(const View& view) {
  Drawn drawn{Image<Rgb>(kCaptureWidth, kCaptureHeight),
              {Image<float>(kCaptureWidth, kCaptureHeight),
               Image<float>(kCaptureWidth, kCaptureHeight, 1.0F)}};
  const Eigen::Vector3d centre = Centre(view.camera_from_world);
  for (int y = 0; y < kCaptureHeight; ++y) {
    for (int x = 0; x < kCaptureWidth; ++x) {
      const double dx = (x + 0.5 - kCaptureWidth / 2.0) / kFocal,
                   dy = (y + 0.5 - kCaptureHeight / 2.0) / kFocal;
      const bool near = IsNear(centre.x() + kNear * dx);
      const double depth = near ? kNear : kFar;
      drawn.color(x, y) = Color(centre.x() + depth * dx, centre.y() + depth * dy, near);
      drawn.depth.depth(x, y) = static_cast<float>(depth);
    }
  }
  return drawn;
}

Workspace WithCapture() {
  Workspace workspace(ScratchFolder());
  CreateFolder(workspace.Stage("poses"));
  CreateFolder(workspace.Stage("depth"));
  ViewSet set;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      View view;
      view.name = "view_" + std::to_string(row) + std::to_string(column);
      view.image = workspace.root() / (view.name + ".png");
      view.camera = {CameraModel::kPinhole,
                     kCaptureWidth,
                     kCaptureHeight,
                     kFocal,
                     kFocal,
                     kCaptureWidth / 2.0,
                     kCaptureHeight / 2.0,
                     {}};
      view.camera_from_world.translation = {-0.5 * (column - 1), -0.5 * (row - 1), 0};
      view.grid = GridPosition{row, column};
      const Drawn drawn = Draw(view);
      WriteSrgb8(view.image, drawn.color.span());
      SaveDepthMap(workspace.Stage("depth") / (view.name + ".exr"), drawn.depth);
      set.views.push_back(std::move(view));
    }
  }
  SaveViewSet(workspace.Stage("poses"), set, {});
  return workspace;
}

LayersOptions SmallDisplay(const Workspace& workspace) {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = kCaptureWidth;
  display.height_px = kCaptureHeight;
  const auto path = workspace.root() / "small.toml";
  WriteTextAtomically(path, ToToml(display));
  LayersOptions options;
  options.display = path.string();
  return options;
}

StageReport MakeLayers(const Workspace& workspace, const LayersOptions& options) {
  StageRun run(workspace, "layers", "in", "options");
  StageReport report = RunLayers(workspace, options, {}, run, SilentProgress());
  run.Commit(report, 0, 0);
  return report;
}

// Mean over pixels and channels.
double Difference(const Image<Rgb>& a, const Image<Rgb>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Rgb d = a.data()[i] - b.data()[i];
    sum += static_cast<double>(std::abs(d.r) + std::abs(d.g) + std::abs(d.b)) / 3;
  }
  return sum / static_cast<double>(a.size());
}

// Where a line of the display meets a plane of the world, by the placement's matrix.
Eigen::Vector3d WorldPoint(const Placement& p, double x, double y, double z) {
  const Eigen::Vector4d world = p.display_from_world.inverse() * Eigen::Vector4d(x, y, z, 1);
  return world.head<3>() / world.w();
}

TEST(StageLayers, ShowsEachPlaneInTheLayerThatIsNearerToIt) {
  const Workspace workspace = WithCapture();
  MakeLayers(workspace, SmallDisplay(workspace));
  const LayersRecord record = LoadLayersRecord(workspace);
  EXPECT_EQ(record.placement.reference_view, "view_11");
  EXPECT_NEAR(record.placement.near, kNear, 1e-4);
  EXPECT_NEAR(record.placement.far, kFar, 1e-4);
  EXPECT_NEAR(record.placement.near_mm, 20, 1e-9);
  EXPECT_NEAR(record.placement.far_mm, -20, 1e-9);
  const LayerImages images = LoadLayerImages(workspace, record);
  double error = 0;
  int compared = 0;
  for (int layer = 0; layer < 2; ++layer) {
    const RayMap map(record.display, layer);
    const double z = layer == 0 ? -20 : 20;
    for (int row = 15; row < kCaptureHeight - 15; ++row) {
      for (int column = 15; column < kCaptureWidth - 15; ++column) {
        const auto x = map.Column(1, column), y = map.Row(1, row);
        if (!x || !y) continue;
        const double offset = z - map.position_mm(), near_offset = 20 - map.position_mm();
        const Eigen::Vector3d point = WorldPoint(record.placement, x->At(offset), y->At(offset), z);
        EXPECT_NEAR(point.z(), layer == 0 ? kFar : kNear, 1e-9);
        // Beams that pass the near plane's edge at some distance.
        const double at_near = WorldPoint(record.placement, x->At(near_offset), 0, 20).x();
        if (std::abs(at_near - 0.2) < 0.12) continue;
        const Rgb seen = images.slots[static_cast<std::size_t>(layer)][4].color(column, row);
        if (images.slots[static_cast<std::size_t>(layer)][4].coverage(column, row) < 0.99F)
          continue;
        if (IsNear(at_near) != (layer == 1)) {
          EXPECT_NEAR(seen.r + seen.g + seen.b, 0, 0.02);  // shadow behind, nothing in front
          continue;
        }
        const Rgb truth = Color(point.x(), point.y(), layer == 1);
        error += std::abs(static_cast<double>(seen.r - truth.r)) +
                 std::abs(static_cast<double>(seen.g - truth.g));
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 500);
  EXPECT_LT(error / compared, 0.03);
}

TEST(StageLayers, TellsWhatShareOfTheRaysWasSeen) {
  const Workspace workspace = WithCapture();
  LayersOptions options = SmallDisplay(workspace);
  MakeLayers(workspace, options);
  const LayersRecord whole = LoadLayersRecord(workspace);
  options.placement.mm_per_view_px = 0.15;  // half as large as the panel
  MakeLayers(workspace, options);
  const LayersRecord small = LoadLayersRecord(workspace);
  EXPECT_GT(whole.seen_share, 0.6);
  EXPECT_LT(small.seen_share, 0.6 * whole.seen_share);
  EXPECT_GT(small.seen_share_in_picture, 1.3 * small.seen_share);
}

TEST(StageLayers, FollowsThePlacementOptions) {
  const Workspace workspace = WithCapture();
  LayersOptions options = SmallDisplay(workspace);
  options.placement.reference_view = "view_02";
  options.placement.viewing_distance_mm = 500;
  options.placement.depth_range = "1,inf";
  options.placement.depth_budget_mm = 30;
  options.border_mm = 7;
  MakeLayers(workspace, options);
  const LayersRecord record = LoadLayersRecord(workspace);
  EXPECT_EQ(record.placement.reference_view, "view_02");
  EXPECT_EQ(record.placement.viewing_distance_mm, 500);
  EXPECT_EQ(record.display.viewing_distance_mm, 500);
  EXPECT_EQ(record.display.border_mm, 7);
  EXPECT_EQ(record.placement.far, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(record.placement.far_mm, -30, 1e-9);
}

TEST(StageLayers, SaysWhyAShallowSceneDoesNotUseTheWholeBudget) {
  const Workspace workspace = WithCapture();
  LayersOptions options = SmallDisplay(workspace);
  options.placement.depth_range = "2,2.01";
  const StageReport report = MakeLayers(workspace, options);
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_THAT(report.warnings[0], HasSubstr("shallower than the depth budget"));
}

TEST(StageLayers, MakesRaysOfTheCalibrationAndKeepsIt) {
  const Workspace workspace = WithCapture();
  LayersOptions options = SmallDisplay(workspace);
  MakeLayers(workspace, options);
  const LayerImages design = LoadLayerImages(workspace, LoadLayersRecord(workspace));
  EXPECT_FALSE(LoadLayersRecord(workspace).calibration);
  Calibration calibration = DesignCalibration(LoadLayersRecord(workspace).display);
  calibration.layers[0].offset_mm = {0.7, -0.4};
  options.calibration = (workspace.root() / "true.json").string();
  SaveCalibration(options.calibration, calibration);
  MakeLayers(workspace, options);
  const LayersRecord record = LoadLayersRecord(workspace);
  ASSERT_TRUE(record.calibration);
  EXPECT_EQ(CalibrationText(*record.calibration), CalibrationText(calibration));
  const LayerImages images = LoadLayerImages(workspace, record);
  // Of the layer whose emitter moved, and of the other one.
  EXPECT_GT(Difference(images.slots[0][4].color, design.slots[0][4].color), 0.01);
  EXPECT_LT(Difference(images.slots[1][4].color, design.slots[1][4].color), 0.001);
}

TEST(StageLayers, RefusesACalibrationThatIsNotOfTheDisplay) {
  const Workspace workspace = WithCapture();
  LayersOptions options = SmallDisplay(workspace);
  options.calibration = (workspace.root() / "true.json").string();
  const auto refusal = [&] {
    try {
      MakeLayers(workspace, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal(), HasSubstr("true.json"));  // there is none
  WriteTextAtomically(options.calibration, "{\"format_version\": 1, \"lay");
  EXPECT_THAT(refusal(), HasSubstr("true.json"));
  Calibration calibration = DesignCalibration(FindDisplay(options.display));
  calibration.display = "another";
  SaveCalibration(options.calibration, calibration);
  EXPECT_THAT(refusal(), HasSubstr("is of the display \"another\""));
  calibration = DesignCalibration(FindDisplay("paper-two-layer"));
  SaveCalibration(options.calibration, calibration);
  EXPECT_THAT(refusal(), HasSubstr("has a panel of 1920 x 1080 px"));
}

TEST(StageLayers, RefusesUnknownDisplaysAndViews) {
  const Workspace workspace = WithCapture();
  LayersOptions options;
  options.display = "paper-two-layr";
  EXPECT_THROW(MakeLayers(workspace, options), Error);
  options = SmallDisplay(workspace);
  options.placement.reference_view = "view_33";
  EXPECT_THROW(MakeLayers(workspace, options), Error);
  options = SmallDisplay(workspace);
  options.border_mm = 20.1;
  EXPECT_THROW(MakeLayers(workspace, options), Error);
}

TEST(StageLayers, WritesTheSameBytesWithAnyNumberOfThreads) {
  const Workspace workspace = WithCapture();
  std::string hashes[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    MakeLayers(workspace, SmallDisplay(workspace));
    hashes[threads - 1] = LoadStageRecord(workspace, "layers")->OutputsHash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(StageLayers, WritesTheSameBytesWithAnyMemoryAndSaysHowMuchItNeeds) {
  const Workspace workspace = WithCapture();
  LayersOptions options = SmallDisplay(workspace);
  Display tall = FindDisplay(options.display);
  tall.height_px = 300;
  WriteTextAtomically(options.display, ToToml(tall));
  const StageReport whole = MakeLayers(workspace, options);
  EXPECT_TRUE(whole.warnings.empty());
  const std::string hash = LoadStageRecord(workspace, "layers")->OutputsHash();
  options.memory_gib = 0.01;  // less than the program itself takes: strips of 32 rows
  const StageReport strips = MakeLayers(workspace, options);
  EXPECT_EQ(LoadStageRecord(workspace, "layers")->OutputsHash(), hash);
  ASSERT_EQ(strips.warnings.size(), 1U);
  EXPECT_THAT(strips.warnings[0], HasSubstr("--memory 0.01 cannot be held"));
  EXPECT_THAT(strips.warnings[0], HasSubstr("is the least that works"));
}

}  // namespace
}  // namespace lamella
