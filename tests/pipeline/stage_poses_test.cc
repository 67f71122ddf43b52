// The stages capture and poses on photographs of a room whose cameras are known exactly.
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/capture/known_cameras.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/capture_record.h"
#include "pipeline/compare_poses.h"
#include "pipeline/poses/colmap.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"
#include "tests/pipeline/textured_room.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

#define REQUIRE_COLMAP() \
  if (!FindColmap()) GTEST_SKIP() << "COLMAP is not installed"

StageReport Capture(const Workspace& workspace, const CaptureOptions& options) {
  StageRun run(workspace, "capture", HashCaptureInput(options), "");
  StageReport report = RunCapture(workspace, options, run, SilentProgress());
  run.Commit(report, 0, 0);
  return report;
}

StageReport Poses(const Workspace& workspace, PosesOptions options = {}) {
  options.features = 700;  // enough here, and fast
  StageRun run(workspace, "poses", "", "");
  StageReport report = RunPoses(workspace, options, run, SilentProgress());
  run.Commit(report, 0, 0);
  return report;
}

CaptureOptions Photographs(const fs::path& folder, const fs::path& cameras = {}) {
  CaptureOptions options;
  options.input = folder.string();
  options.cameras = cameras.string();
  return options;
}

Camera Lens() {
  return {.model = CameraModel::kBrown,
          .width = 480,
          .height = 360,
          .fx = 450,
          .fy = 450,
          .cx = 240,
          .cy = 180,
          .distortion = {-0.08}};
}

// Photographs of the room under awkward names; truth.views has their cameras.
std::vector<View> PhotographTo(const fs::path& folder, int count, const Camera& camera) {
  std::vector<View> truth;
  const std::vector<Rigid> poses = ArcOfCameras(count);
  fs::create_directories(folder);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    View view;
    view.name = "R\xC3\xA4um " + std::to_string(i);
    view.image = folder / (view.name + ".png");
    view.camera = camera;
    view.camera_from_world = poses[i];
    WriteSrgb8(view.image, PhotographRoom(camera, poses[i]).span());
    truth.push_back(view);
  }
  return truth;
}

std::map<std::string, std::string> Contents(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    contents[fs::relative(entry.path(), folder).string()] = {std::istreambuf_iterator<char>(file),
                                                             {}};
  }
  return contents;
}

TEST(StagePoses, FindsTheCamerasOfPhotographsAndTheSameBytesWithOneThreadAndTwo) {
  REQUIRE_COLMAP();
  const fs::path folder = ScratchFolder();
  const std::vector<View> truth = PhotographTo(folder / "in", 6, Lens());
  // A photograph of something else, of another size.
  Camera other = Lens();
  other.width = 400;
  WriteSrgb8(folder / "in" / "elsewhere.png", PhotographRoom(other, ArcOfCameras(1)[0], 77).span());

  const Workspace workspace(folder / "w");
  Capture(workspace, Photographs(folder / "in"));
  StageReport report;
  {
    const ThreadLimit two(2);
    report = Poses(workspace);
  }
  EXPECT_NE(report.missed_gate.find("elsewhere"), std::string::npos) << report.missed_gate;
  EXPECT_EQ(LoadLostViews(workspace), std::vector<std::string>{"elsewhere"});

  const ViewSet set = LoadViewSet(workspace);
  ASSERT_EQ(set.views.size(), 6U);
  const PoseComparison comparison = ComparePoses(set.views, truth);
  EXPECT_LT(comparison.max, 0.02) << "of an arc 3.2 wide";
  EXPECT_LT(comparison.mean_rotation_deg, 0.2);
  EXPECT_NEAR(set.views[0].camera.fx, 450, 9);
  EXPECT_EQ(set.views[0].camera.model, CameraModel::kPinhole);
  EXPECT_EQ(set.views[0].image, folder / "w/poses/colmap/images" / (truth[0].name + ".png"));

  // Points lie on the room's surfaces.
  ASSERT_GT(set.points.size(), 100U);
  int near = 0;
  for (const SparsePoint& point : set.points) {
    EXPECT_GE(point.views.size(), 2U);
    const Eigen::Vector3d position = comparison.truth_from_estimate * point.position;
    near += DistanceFromRoom(position) < 0.03 * position.norm();
  }
  EXPECT_GT(near, static_cast<int>(0.9 * static_cast<double>(set.points.size())));
  EXPECT_EQ(ReadImageInfo(set.views[3].image).width, 480);

  EXPECT_FALSE(fs::exists(folder / "w/poses/scratch"));
  const auto first = Contents(folder / "w/poses");
  fs::remove_all(folder / "w/poses");
  const ThreadLimit one(1);
  Poses(workspace);
  EXPECT_TRUE(first == Contents(folder / "w/poses"));
}

TEST(StagePoses, HoldsKnownCamerasAndTriangulatesPoints) {
  REQUIRE_COLMAP();
  const fs::path folder = ScratchFolder();
  Camera pinhole = Lens();
  pinhole.model = CameraModel::kPinhole;
  pinhole.distortion = {};
  pinhole.cx = 236.5;
  const std::vector<View> truth = PhotographTo(folder / "in", 4, pinhole);
  WriteTransformsJson(folder / "cameras.json", {truth, {}});
  const Workspace workspace(folder / "w");
  Capture(workspace, Photographs(folder / "in", folder / "cameras.json"));
  EXPECT_EQ(Poses(workspace).missed_gate, "");
  const ViewSet set = LoadViewSet(workspace);
  ASSERT_EQ(set.views.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const Rigid& pose = set.views[i].camera_from_world;
    EXPECT_LT((Centre(pose) - Centre(truth[i].camera_from_world)).norm(), 1e-12);
    EXPECT_LT(pose.rotation.angularDistance(truth[i].camera_from_world.rotation), 1e-12);
    EXPECT_EQ(set.views[i].camera.cx, 236.5);
    EXPECT_EQ(set.views[i].image, truth[i].image);  // nothing to undistort
  }
  ASSERT_GT(set.points.size(), 50U);
  int near = 0;
  for (const SparsePoint& point : set.points) near += DistanceFromRoom(point.position) < 0.05;
  EXPECT_GT(near, static_cast<int>(0.9 * static_cast<double>(set.points.size())));

  // Cameras in OpenGL's axes, taken for ours: all points lie behind them.
  std::vector<View> wrong = truth;
  for (View& view : wrong) {
    view.camera_from_world =
        Rigid{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()} * view.camera_from_world;
  }
  WriteTransformsJson(folder / "wrong.json", {wrong, {}});
  const Workspace second(folder / "w2");
  Capture(second, Photographs(folder / "in", folder / "wrong.json"));
  EXPECT_THROW(Poses(second), Error);
}

TEST(StagePoses, SaysSoWherePhotographsDoNotOverlap) {
  REQUIRE_COLMAP();
  const fs::path folder = ScratchFolder();
  fs::create_directory(folder / "in");
  for (unsigned i = 0; i < 3; ++i) {
    WriteSrgb8(folder / "in" / (std::to_string(i) + ".png"),
               PhotographRoom(Lens(), ArcOfCameras(1)[0], 5 + 10 * i).span());
  }
  WriteSrgb8(folder / "in" / "one pixel.png", Image<Rgb>(1, 1).span());
  const Workspace workspace(folder / "w");
  Capture(workspace, Photographs(folder / "in"));
  try {
    Poses(workspace);
    FAIL() << "found poses";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_NE(std::string(error.what()).find("overlap"), std::string::npos) << error.what();
  }
}

TEST(StagePoses, FallsBackToLittleParallaxAndWarns) {
  REQUIRE_COLMAP();
  const fs::path folder = ScratchFolder();
  fs::create_directory(folder / "in");
  const Rigid first = ArcOfCameras(1)[0];
  Rigid second = first;  // the box is seen under an angle of 1 degree
  second.translation.x() -= 0.07;
  WriteSrgb8(folder / "in/a.png", PhotographRoom(Lens(), first).span());
  WriteSrgb8(folder / "in/b.png", PhotographRoom(Lens(), second).span());
  const Workspace workspace(folder / "w");
  Capture(workspace, Photographs(folder / "in"));
  const StageReport report = Poses(workspace);
  EXPECT_EQ(report.missed_gate, "");
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_NE(report.warnings[0].find("parallax"), std::string::npos);
}

TEST(StagePoses, TakesAGridAsItIsGiven) {
  const fs::path folder = ScratchFolder();
  std::ofstream(folder / "parameters.cfg")
      << "[intrinsics]\nfocal_length_mm = 100\nimage_resolution_x_px = 16\n"
         "image_resolution_y_px = 12\nsensor_size_mm = 35\n[extrinsics]\nnum_cams_x = 3\n"
         "num_cams_y = 3\nbaseline_mm = 25\nfocus_distance_m = 4\n";
  for (int i = 0; i < 9; ++i) {
    WriteSrgb8(folder / ("input_Cam00" + std::to_string(i) + ".png"),
               Image<Rgb>(16, 12, {0.1F * static_cast<float>(i), 0, 0}).span());
  }
  const Workspace workspace(folder / "w");
  CaptureOptions options = Photographs(folder);
  options.views = "input_Cam00[02],input_Cam004,!*2";
  Capture(workspace, options);
  Poses(workspace);
  const ViewSet set = LoadViewSet(workspace);
  ASSERT_EQ(set.views.size(), 2U);
  EXPECT_EQ(set.views[1].grid, (GridPosition{1, 1}));
  EXPECT_EQ(set.views[1].image, folder / "input_Cam004.png");
  const auto grid = FindRegularGrid(set.views);
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->disparity_per_inverse_depth, 0.025 * 100 / 35 * 16, 1e-9);
  // Its own transforms.json is a capture of the same grid.
  const Workspace again(folder / "w2");
  Capture(again, Photographs(folder / "w/poses/transforms.json"));
  Poses(again);
  EXPECT_EQ(Contents(folder / "w/poses").at("transforms.json"),
            Contents(folder / "w2/poses").at("transforms.json"));
}

std::vector<std::string> RunningPrograms(const std::string& name) {
  std::vector<std::string> running;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");
    std::string id, program, state;
    if (stat >> id >> program >> state && program == "(" + name + ")" && state != "Z") {
      std::ifstream command(entry.path() / "cmdline", std::ios::binary);
      running.emplace_back(std::istreambuf_iterator<char>(command),
                           std::istreambuf_iterator<char>());
    }
  }
  return running;
}

TEST(StagePoses, KilledInBetweenLeavesNoColmapAndRunsAgainToTheSameBytes) {
  REQUIRE_COLMAP();
  const fs::path folder = ScratchFolder();
  PhotographTo(folder / "in", 3, Lens());
  const Workspace workspace(folder / "w");
  Capture(workspace, Photographs(folder / "in"));
  Poses(workspace);
  const auto undisturbed = Contents(folder / "w/poses");
  fs::remove_all(folder / "w/poses");

  const auto ours = [&] {
    int count = 0;
    for (const std::string& command : RunningPrograms("colmap")) {
      count += command.find(folder.string()) != std::string::npos;
    }
    return count;
  };
  const pid_t child = fork();
  if (child == 0) {
    Poses(workspace);
    _exit(0);
  }
  for (int i = 0; i < 1000 && ours() == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_GT(ours(), 0);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  for (int i = 0; i < 200 && ours() > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(ours(), 0);
  Poses(workspace);
  EXPECT_TRUE(undisturbed == Contents(folder / "w/poses"));
}

}  // namespace
}  // namespace lamella
