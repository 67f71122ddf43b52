#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"
#include "pipeline/synth_scene.h"
#include "tests/depth/synthetic.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

TEST(DepthRecord, ReadsBackTheSameBits) {
  const fs::path path = ScratchFolder() / "a.exr";
  DepthMap map{Image<float>(7, 5, 1.25F), Image<float>(7, 5, 1.0F / 3)};
  map.depth(1, 2) = 0;
  map.confidence(1, 2) = 0;
  map.depth(2, 2) = std::numeric_limits<float>::infinity();
  map.depth(3, 2) = 1e-38F;
  map.depth(4, 2) = 1e38F;
  SaveDepthMap(path, map);
  const DepthMap again = LoadDepthMap(path);
  ASSERT_EQ(again.depth.width(), 7);
  EXPECT_EQ(0, std::memcmp(map.depth.data(), again.depth.data(), map.depth.size() * sizeof(float)));
  EXPECT_EQ(0, std::memcmp(map.confidence.data(), again.confidence.data(),
                           map.depth.size() * sizeof(float)));
}

TEST(DepthRecord, RefusesWhatNoDepthMapCanHold) {
  const fs::path folder = ScratchFolder();
  EXPECT_THROW(LoadDepthMap(folder / "absent.exr"), Error);
  DepthMap map{Image<float>(3, 3, 1.0F), Image<float>(3, 3, 1.0F)};
  map.depth(1, 1) = -2;
  SaveDepthMap(folder / "negative.exr", map);
  EXPECT_THROW(LoadDepthMap(folder / "negative.exr"), Error);
  map.depth(1, 1) = std::numeric_limits<float>::quiet_NaN();
  SaveDepthMap(folder / "nan.exr", map);
  EXPECT_THROW(LoadDepthMap(folder / "nan.exr"), Error);
}

TEST(DepthRecord, PointsAreABinaryPly) {
  const fs::path path = ScratchFolder() / "points.ply";
  SavePoints(path, {{{1e7 + 0.125, 2, -3}, {1, 2, 3}}, {{0, 0, 0}, {255, 0, 7}}});
  const std::string ply = ReadText(path);
  const std::string end = "end_header\n";
  const std::size_t body = ply.find(end) + end.size();
  EXPECT_NE(ply.find("format binary_little_endian 1.0\nelement vertex 2\n"), std::string::npos);
  ASSERT_EQ(ply.size(), body + 2 * 27);
  double x = 0;
  std::memcpy(&x, ply.data() + body, sizeof(x));
  EXPECT_EQ(x, 1e7 + 0.125);
  EXPECT_EQ(static_cast<unsigned char>(ply[body + 24]), 1);
  EXPECT_EQ(static_cast<unsigned char>(ply[body + 27 + 26]), 7);
}

// A workspace whose stage poses has left a 3x3 grid before a slanted wall.
Workspace GridWorkspace(const fs::path& root) {
  Workspace workspace(root);
  CreateFolder(workspace.Stage("poses"));
  ViewSet set;
  set.views = synthetic::MakeGrid(3, 3, 64, 80, 0.2, 9);
  const Eigen::Vector3d u = Eigen::Vector3d(1, 0, 0.3).normalized();
  const synthetic::Panel wall{{0, 0, 9}, u, {0, 1, 0}, 40, 40, 0.3, 1, true};
  for (View& view : set.views) {
    view.image = workspace.Stage("poses") / (view.name + ".png");
    WriteCodes8(view.image,
                synthetic::Render({wall}, view.camera, view.camera_from_world).image.span());
  }
  SaveViewSet(workspace.Stage("poses"), set, {});
  return workspace;
}

TEST(StageDepth, TakesTheDepthThatCameWithTheCapture) {
  const Workspace workspace = GridWorkspace(ScratchFolder());
  ViewSet set = LoadViewSet(workspace);
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    View& view = set.views[i];
    Image<float> depth(view.camera.width, view.camera.height, 2.0F + static_cast<float>(i));
    depth(3, 4) = 0;
    depth(5, 6) = std::numeric_limits<float>::infinity();
    view.depth = workspace.root() / (view.name + "_given.exr");
    std::vector<Channel> channels;
    channels.push_back({"Z", std::move(depth)});
    WriteExr(view.depth, channels, ExrType::kFloat);
  }
  SaveViewSet(workspace.Stage("poses"), set, {});
  DepthOptions options;
  options.source = "given";
  StageRun run(workspace, "depth", "in", "options");
  const StageReport report = RunDepth(workspace, options, run, SilentProgress());
  run.Commit(report, 0, 0);
  EXPECT_EQ(report.summary[0].second, "given with the capture");
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    const DepthMap map = LoadDepthMap(workspace.Stage("depth") / (set.views[i].name + ".exr"));
    EXPECT_EQ(map.depth(1, 1), 2.0F + static_cast<float>(i));
    EXPECT_EQ(map.confidence(1, 1), 1);
    EXPECT_EQ(map.confidence(3, 4), 0);
    EXPECT_TRUE(std::isinf(map.depth(5, 6)));
    EXPECT_EQ(map.confidence(5, 6), 1);
  }
}

// What capture, poses and depth make of `capture` with --depth given.
StageReport RunGiven(const Workspace& workspace, const fs::path& capture) {
  CaptureOptions options;
  options.input = capture.string();
  StageRun captured(workspace, "capture", "", "");
  captured.Commit(RunCapture(workspace, options, captured, SilentProgress()), 0, 0);
  StageRun posed(workspace, "poses", "", "");
  posed.Commit(RunPoses(workspace, {}, posed, SilentProgress()), 0, 0);
  DepthOptions given;
  given.source = "given";
  StageRun run(workspace, "depth", "", "");
  return RunDepth(workspace, given, run, SilentProgress());
}

// A generated grid of cards before a wall; all but the centre view's depth is left out.
TEST(StageDepth, ViewsWithoutDepthGetItFromThoseThatCameWithIt) {
  const fs::path root = ScratchFolder(), scene = root / "scene";
  Recipe recipe = FindRecipe("occluder");
  recipe.layout.layout = "grid";
  recipe.layout.views = 9;
  recipe.layout.spacing = 0.04;
  recipe.layout.width_px = 240;
  SynthScene(std::move(recipe), scene, SilentProgress());
  TransformsJson transforms = ReadTransformsJson(scene);
  for (View& view : transforms.views) {
    if (view.grid != GridPosition{1, 1}) view.depth.clear();
  }
  WriteTransformsJson(scene / "transforms.json", transforms);
  const Workspace workspace(root / "W");
  const StageReport report = RunGiven(workspace, scene);
  EXPECT_EQ(report.summary[1].second, "8 views, from the 1 that came with depth");

  for (const View& view : transforms.views) {
    const DepthMap map = LoadDepthMap(workspace.Stage("depth") / (view.name + ".exr"));
    const Image<float> truth = LoadDepth(scene / "depth" / (view.name + ".exr"));
    int good = 0, guessed = 0, good_guesses = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const float error = std::abs(map.depth.data()[i] - truth.data()[i]);
      const bool is_good = error < 0.005F * truth.data()[i];
      const bool is_guess = map.confidence.data()[i] < 0.5F;
      guessed += is_guess;
      good += is_good && !is_guess;
      good_guesses += is_good && is_guess;
    }
    const int sure = static_cast<int>(truth.size()) - guessed;
    EXPECT_GT(good, 0.985 * sure) << view.name;  // all but the pixels at the cards' edges
    EXPECT_LT(guessed, 0.06 * static_cast<double>(truth.size()));
    EXPECT_GE(good_guesses, 0.6 * guessed) << view.name;  // the wall behind
  }
}

TEST(StageDepth, SaysWhichViewCameWithoutDepthOrWithDepthOfAnotherSize) {
  const Workspace workspace = GridWorkspace(ScratchFolder());
  DepthOptions options;
  options.source = "given";
  StageRun run(workspace, "depth", "in", "options");
  const auto message = [&] {
    try {
      RunDepth(workspace, options, run, SilentProgress());
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message().find("came without depth"), std::string::npos) << message();
  ViewSet set = LoadViewSet(workspace);
  for (View& view : set.views) view.depth = workspace.root() / "small.exr";
  std::vector<Channel> channels;
  channels.push_back({"Z", Image<float>(5, 7, 1.0F)});
  WriteExr(workspace.root() / "small.exr", channels, ExrType::kFloat);
  SaveViewSet(workspace.Stage("poses"), set, {});
  EXPECT_NE(message().find("is 5x7 px, its photograph 64x64 px"), std::string::npos) << message();
  fs::remove(workspace.root() / "small.exr");
  EXPECT_NE(message().find("small.exr"), std::string::npos) << message();
}

struct Stopped {};

// As if the run was killed when so many maps were written.
class StopsAfter final : public Progress {
 public:
  explicit StopsAfter(int maps) : maps_(maps) {}
  void Start(std::string_view, std::int64_t, std::string_view) override {
    if (maps_ == 0) throw Stopped();
  }
  void Advance(std::int64_t units) override {
    if ((maps_ -= units) == 0) throw Stopped();
  }
  void Note(std::string_view) override {}
  void Warn(std::string_view) override {}

 private:
  std::int64_t maps_;
};

StageReport RunOnce(const Workspace& workspace, Progress& progress = SilentProgress()) {
  DepthOptions options;
  ApplyQuality(Quality::kBalanced, options);
  StageRun run(workspace, "depth", "inputs", "options");
  return RunDepth(workspace, options, run, progress);
}

std::map<std::string, std::string> FilesOf(const Workspace& workspace) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(workspace.Stage("depth"))) {
    if (!entry.is_regular_file() || entry.path().filename() == "stage.json") continue;
    files[fs::relative(entry.path(), workspace.Stage("depth")).string()] = ReadText(entry.path());
  }
  return files;
}

TEST(StageDepth, LeavesAMapOfEveryViewAndPointsOnTheWall) {
  const Workspace workspace = GridWorkspace(ScratchFolder());
  const StageReport report = RunOnce(workspace);
  const auto files = FilesOf(workspace);
  EXPECT_EQ(files.size(), 10U);  // nothing of the passes is left
  EXPECT_EQ(files.count("view104.exr"), 1U);
  EXPECT_EQ(files.count("points.ply"), 1U);
  EXPECT_TRUE(report.warnings.empty());
  const DepthMap map = LoadDepthMap(workspace.Stage("depth") / "view104.exr");
  EXPECT_NEAR(map.depth(32, 32), 9, 0.1);
  // Each point lies on the wall, z = 9 + 0.3 x.
  const std::string& ply = files.at("points.ply");
  const std::size_t body = ply.find("end_header\n") + 11;
  ASSERT_GT(ply.size(), body + 27 * 10000);
  std::size_t off = 0, points = 0;
  for (std::size_t i = body; i + 27 <= ply.size(); i += 27, ++points) {
    double p[3];
    std::memcpy(p, ply.data() + i, sizeof(p));
    off += std::abs(p[2] - 9 - 0.3 * p[0]) > 0.4 ? 1 : 0;  // 0.08 px
  }
  EXPECT_LT(off, points / 20);
}

TEST(StageDepth, GoesOnFromWhateverAKilledRunHasLeftToTheSameBytes) {
  const fs::path root = ScratchFolder();
  const Workspace whole = GridWorkspace(root / "whole");
  RunOnce(whole);
  const auto expected = FilesOf(whole);

  const Workspace killed = GridWorkspace(root / "killed");
  for (const int maps : {0, 4, 12}) {  // before any, in the middle of pass 0, of the last pass
    fs::remove_all(killed.Stage("depth"));
    StopsAfter progress(maps);
    EXPECT_THROW(RunOnce(killed, progress), Stopped);
    const auto left = FilesOf(killed);
    EXPECT_EQ(static_cast<int>(left.size()), maps);
    RunOnce(killed);
    EXPECT_EQ(FilesOf(killed), expected);
  }
  // Killed while the last maps were written.
  fs::remove(killed.Stage("depth") / "view105.exr");
  fs::remove(killed.Stage("depth") / "points.ply");
  WriteTextAtomically(killed.Stage("depth") / "view106.partial.exr", "cut");
  fs::remove(killed.Stage("depth") / "view106.exr");
  RunOnce(killed);
  EXPECT_EQ(FilesOf(killed), expected);
  // A map that an earlier run finished is not made again: a wrong one in its place shows.
  fs::remove_all(killed.Stage("depth"));
  StopsAfter progress(4);
  EXPECT_THROW(RunOnce(killed, progress), Stopped);
  SaveDepthMap(killed.Stage("depth") / FilesOf(killed).begin()->first,
               {Image<float>(64, 64, 2.0F), Image<float>(64, 64, 1.0F)});
  RunOnce(killed);
  EXPECT_NE(FilesOf(killed), expected);
  fs::remove_all(killed.Stage("depth"));
  RunOnce(killed);
  // Killed after the last map.
  fs::remove(killed.Stage("depth") / "points.ply");
  RunOnce(killed);
  EXPECT_EQ(FilesOf(killed), expected);
}

}  // namespace
}  // namespace lamella
