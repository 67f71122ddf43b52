#include <fstream>
#include <functional>
#include <iterator>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/capture/input.h"
#include "pipeline/capture/photographs.h"
#include "pipeline/capture/select_views.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/capture_record.h"
#include "pipeline/stages.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

void WritePicture(const fs::path& path, int width = 8, int height = 6) {
  fs::create_directories(path.parent_path());
  const Image<Rgb8> picture(width, height, {10, 20, 30});
  WriteCodes8(path, picture.span());
}

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

CaptureRecord Capture(const fs::path& folder, const CaptureOptions& options) {
  const Workspace workspace(folder / "workspace");
  fs::remove_all(workspace.root());
  StageRun run(workspace, "capture", HashCaptureInput(options), "");
  RunCapture(workspace, options, run, SilentProgress());
  return LoadCapture(workspace);
}

CaptureOptions Input(const fs::path& path) {
  CaptureOptions options;
  options.input = path.string();
  return options;
}

void ExpectRefused(ExitCode code, const CaptureOptions& options,
                   const std::vector<std::string>& words) {
  try {
    Capture(fs::path(options.input).parent_path() / "refused", options);
    FAIL() << options.input << " was taken";
  } catch (const Error& error) {
    const std::string line = error.what();
    EXPECT_EQ(error.code(), code) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    for (const std::string& word : words) EXPECT_NE(line.find(word), std::string::npos) << line;
  }
}

TEST(SelectViews, TakesNamesGlobsAndLeavesOut) {
  const std::vector<std::string> names = {"a1", "a2", "b1", "b[2]"};
  using Chosen = std::vector<bool>;
  EXPECT_EQ(SelectViews(names, "a1"), (Chosen{true, false, false, false}));
  EXPECT_EQ(SelectViews(names, "a*,b1"), (Chosen{true, true, true, false}));
  EXPECT_EQ(SelectViews(names, "!a1"), (Chosen{false, true, true, true}));
  EXPECT_EQ(SelectViews(names, "?1,!b*"), (Chosen{true, false, false, false}));
  EXPECT_EQ(SelectViews(names, "!a?,a2,*"), (Chosen{false, false, true, true}));
  EXPECT_EQ(SelectViews(names, "b[2]"), (Chosen{false, false, false, true}));
}

TEST(SelectViews, RefusesPatternsThatMeetNothingAndOffersTheNearestName) {
  const std::vector<std::string> names = {"first", "second"};
  for (const char* patterns : {"frist", "!frist", "first,frist", "frist*"}) {
    try {
      SelectViews(names, patterns);
      ADD_FAILURE() << patterns;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      EXPECT_NE(std::string(error.what()).find("\"first\""), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(SelectViews(names, "!first,!second"), Error);
  EXPECT_THROW(SelectViews(names, "first,,second"), Error);
}

TEST(GuessFocal, PrefersTheDiagonalOf35mmFilmThenTheSensorThenAGuess) {
  ImageInfo info;
  info.width = 3600;
  info.height = 2400;
  EXPECT_NEAR(GuessFocal(info).focal_px, 1.2 * 3600, 1e-9);
  EXPECT_EQ(GuessFocal(info).origin, CameraOrigin::kGuess);
  info.focal_mm = 5;
  info.sensor_longer_mm = 6;
  EXPECT_NEAR(GuessFocal(info).focal_px, 3000, 1e-9);
  info.focal_35mm = 28;  // 3:2 pictures have the film's shape
  EXPECT_NEAR(GuessFocal(info).focal_px, 2800, 1e-9);
  EXPECT_EQ(GuessFocal(info).origin, CameraOrigin::kExif);
  info.focal_35mm = 1e6;  // a lie
  EXPECT_EQ(GuessFocal(info).origin, CameraOrigin::kGuess);
}

TEST(StageCapture, ListsPhotographsAndLeavesOutWhatDoesNotClaimToBeOne) {
  const fs::path folder = ScratchFolder();
  WritePicture(folder / "in/b.JPG", 8, 6);
  WritePicture(folder / "in/a c.png", 6, 8);
  WriteText(folder / "in/Readme.txt", "hello");
  WriteText(folder / "in/K.txt", "1 0 0");
  WriteText(folder / "in/.hidden.png", "no picture");
  const CaptureRecord record = Capture(folder, Input(folder / "in/"));
  ASSERT_EQ(record.views.size(), 2U);
  EXPECT_EQ(record.views[0].name, "a c");
  EXPECT_EQ(record.views[0].file, folder / "in/a c.png");
  EXPECT_EQ(record.views[0].camera.width, 6);
  EXPECT_EQ(record.views[0].sha256, Sha256OfFile(folder / "in/a c.png"));
  EXPECT_TRUE(record.views[0].is_plain);
  EXPECT_FALSE(record.views[0].camera_from_world);
  EXPECT_EQ(record.views[1].name, "b");
  EXPECT_NEAR(record.views[1].camera.fx, 1.2 * 8, 1e-12);
  EXPECT_EQ(record.views[1].camera.cy, 3);
}

TEST(StageCapture, RefusesInOneLineWhatCanNotBeUsed) {
  const fs::path folder = ScratchFolder();
  fs::create_directory(folder / "empty");
  ExpectRefused(ExitCode::kInput, Input(folder / "empty"), {"empty", "no image"});
  ExpectRefused(ExitCode::kInput, Input(folder / "absent"), {"absent", "does not exist"});
  WritePicture(folder / "deep/images/a.png");
  ExpectRefused(ExitCode::kInput, Input(folder / "deep"), {"did you mean", "deep/images"});
  ExpectRefused(ExitCode::kInput, Input(folder / "deep/images"), {"only one view", "\"a\""});
  ExpectRefused(ExitCode::kInput, Input(folder / "deep/images/a.png"), {"neither a folder"});
  WritePicture(folder / "twice/a.png");
  WritePicture(folder / "twice/a.jpg");
  ExpectRefused(ExitCode::kInput, Input(folder / "twice"), {"a.png", "a.jpg", "stem"});
  WritePicture(folder / "text/a.png");
  WritePicture(folder / "text/b.png");
  WriteText(folder / "text/c.png", "a text");
  ExpectRefused(ExitCode::kInput, Input(folder / "text"), {"c.png"});
  CaptureOptions without = Input(folder / "text");
  without.views = "!c";
  EXPECT_EQ(Capture(folder, without).views.size(), 2U);
  WritePicture(folder / "cut/a.jpg", 64, 64);
  WriteText(folder / "cut/b.jpg", ReadAll(folder / "cut/a.jpg").substr(0, 400));
  WriteText(folder / "cut/c.jpg", "");
  ExpectRefused(ExitCode::kInput, Input(folder / "cut"), {"b.jpg", "truncated"});
  without = Input(folder / "cut");
  without.views = "!b";
  ExpectRefused(ExitCode::kInput, without, {"c.jpg", "empty"});
  without.views = "b,x*";
  ExpectRefused(ExitCode::kUsage, without, {"--views", "x*"});
}

void WriteGrid(const fs::path& folder, int odd_one_out) {
  for (int i = 0; i < 4; ++i) {
    WritePicture(folder / ("input_Cam00" + std::to_string(i) + ".png"), i == odd_one_out ? 10 : 8);
  }
  WriteText(folder / "parameters.cfg",
            "[intrinsics]\nfocal_length_mm = 100\nimage_resolution_x_px = 16\n"
            "image_resolution_y_px = 12\nsensor_size_mm = 35\n[extrinsics]\nnum_cams_x = 2\n"
            "num_cams_y = 2\nbaseline_mm = 25\nfocus_distance_m = 4\n");
}

TEST(StageCapture, FitsAGridsCamerasToImagesThatWereMadeSmaller) {
  const fs::path folder = ScratchFolder();
  WriteGrid(folder / "in", -1);
  for (const fs::path& input : {folder / "in", folder / "in" / "parameters.cfg"}) {
    const CaptureRecord record = Capture(folder, Input(input));
    ASSERT_EQ(record.views.size(), 4U);
    EXPECT_EQ(record.views[3].grid, (GridPosition{1, 1}));
    EXPECT_EQ(record.views[3].camera.width, 8);
    EXPECT_NEAR(record.views[3].camera.fx, 100.0 / 35 * 8, 1e-12);
    const auto known = KnownViews(record);
    ASSERT_TRUE(known && FindRegularGrid(*known));
  }
  EXPECT_FALSE(NeedsColmap(Input(folder / "in")));
}

TEST(StageCapture, RefusesGridsOfSeveralSizesAndBrokenParameters) {
  const fs::path folder = ScratchFolder();
  WriteGrid(folder / "in", 2);
  ExpectRefused(ExitCode::kInput, Input(folder / "in"), {"input_Cam002", "size", "10x6"});
  WriteGrid(folder / "in", -1);
  fs::remove(folder / "in/input_Cam001.png");
  ExpectRefused(ExitCode::kInput, Input(folder / "in"), {"input_Cam001"});
  WriteText(folder / "in/parameters.cfg", "[intrinsics]\nfocal_length_mm = abc\n");
  ExpectRefused(ExitCode::kInput, Input(folder / "in"), {"parameters.cfg"});
}

TEST(StageCapture, GivesPhotographsKnownCameras) {
  const fs::path folder = ScratchFolder();
  WritePicture(folder / "in/a.png", 8, 6);
  WritePicture(folder / "in/b.png", 8, 6);
  std::vector<View> known(2);
  for (std::size_t i = 0; i < 2; ++i) {
    known[i].name = i == 0 ? "a" : "b";
    known[i].image = folder / "elsewhere" / (known[i].name + ".png");
    known[i].camera = {.width = 16, .height = 12, .fx = 20, .fy = 20, .cx = 9, .cy = 6};
    known[i].camera_from_world.translation.x() = 0.1 * static_cast<double>(i);
  }
  WriteTransformsJson(folder / "cameras.json", {known, {}});
  CaptureOptions options = Input(folder / "in");
  options.cameras = (folder / "cameras.json").string();
  const CaptureRecord record = Capture(folder, options);
  ASSERT_EQ(record.views.size(), 2U);
  EXPECT_EQ(record.views[1].camera_origin, CameraOrigin::kKnown);
  EXPECT_EQ(record.views[1].camera.cx, 4.5);  // of the smaller picture
  EXPECT_EQ(record.views[1].file, folder / "in/b.png");
  ASSERT_TRUE(record.views[1].camera_from_world);
  EXPECT_NEAR(record.views[1].camera_from_world->translation.x(), 0.1, 1e-12);

  WritePicture(folder / "in/c.png", 8, 6);
  ExpectRefused(ExitCode::kInput, options, {"cameras.json", "\"c\""});
  fs::remove(folder / "in/c.png");
  WritePicture(folder / "in/b.png", 6, 8);
  ExpectRefused(ExitCode::kInput, options, {"b.png", "6x8", "16x12"});
}

TEST(StageCapture, TakesDepthThatIsNamedAndLeftBehindForNone) {
  const fs::path folder = ScratchFolder();
  std::vector<View> known(2);
  for (std::size_t i = 0; i < 2; ++i) {
    known[i].name = i == 0 ? "a" : "b";
    known[i].image = folder / "in" / (known[i].name + ".png");
    WritePicture(known[i].image, 8, 6);
    known[i].camera = {.width = 8, .height = 6, .fx = 10, .fy = 10, .cx = 4, .cy = 3};
    known[i].camera_from_world.translation.x() = 0.1 * static_cast<double>(i);
    known[i].depth = folder / "in" / (known[i].name + ".exr");
  }
  WriteTransformsJson(folder / "in/transforms.json", {known, {}});
  const CaptureOptions options = Input(folder / "in/transforms.json");
  const std::string without = HashCaptureInput(options);
  EXPECT_EQ(Capture(folder, options).views[0].depth_sha256, "");
  WriteText(known[0].depth, "depth");
  EXPECT_NE(HashCaptureInput(options), without);
  const CaptureRecord record = Capture(folder, options);
  EXPECT_EQ(record.views[0].depth, known[0].depth);
  EXPECT_EQ(record.views[0].depth_sha256.size(), 64U);
}

TEST(HashCaptureInput, ChangesWithContentNamesSelectionAndCameras) {
  const fs::path folder = ScratchFolder();
  for (const char* name : {"a", "b", "c"})
    WritePicture(folder / "in" / (std::string(name) + ".png"));
  const CaptureOptions options = Input(folder / "in");
  const std::string first = HashCaptureInput(options);
  EXPECT_EQ(HashCaptureInput(options), first);
  WriteText(folder / "in/notes.txt", "not a picture");
  EXPECT_EQ(HashCaptureInput(options), first);
  CaptureOptions some = options;
  some.views = "!c";
  EXPECT_NE(HashCaptureInput(some), first);
  fs::rename(folder / "in/c.png", folder / "in/d.png");
  const std::string renamed = HashCaptureInput(options);
  EXPECT_NE(renamed, first);
  WritePicture(folder / "in/d.png", 9, 6);
  EXPECT_NE(HashCaptureInput(options), renamed);
}

TEST(StageCapture, WritesTheSameBytesWithOneThreadAndTwo) {
  const fs::path folder = ScratchFolder();
  for (int i = 0; i < 7; ++i) WritePicture(folder / "in" / (std::to_string(i) + ".png"), 8 + i);
  std::string first;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    Capture(folder, Input(folder / "in"));
    const std::string text = ReadAll(folder / "workspace/capture/capture.json");
    if (first.empty()) first = text;
    EXPECT_EQ(text, first);
  }
}

TEST(CaptureRecord, IsReadBackAsItWasWrittenAndANewerOneIsRefused) {
  const fs::path folder = ScratchFolder();
  CapturedView view;
  view.name = "n\xC3\xA4me";
  view.file = "/some where/n\xC3\xA4me.tif";
  view.sha256 = "00ff";
  view.orientation = 6;
  view.is_plain = false;
  view.device = "Maker Model 5.85 mm";
  view.camera_origin = CameraOrigin::kKnown;
  view.camera = {.model = CameraModel::kBrown,
                 .width = 5,
                 .height = 7,
                 .fx = 1.0 / 3,
                 .fy = 2,
                 .cx = 3,
                 .cy = 4,
                 .distortion = {1, 2, 3, 4, 5, 6, 7, 8}};
  view.camera_from_world = Rigid{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 1.0 / 3}};
  view.grid = GridPosition{3, -4};
  fs::create_directories(folder / "capture");
  SaveCapture(folder / "capture", {{view}});
  const CapturedView back = LoadCapture(Workspace(folder)).views.at(0);
  EXPECT_EQ(back.name, view.name);
  EXPECT_EQ(back.file, view.file);
  EXPECT_EQ(back.orientation, 6);
  EXPECT_FALSE(back.is_plain);
  EXPECT_EQ(back.device, view.device);
  EXPECT_EQ(back.camera_origin, CameraOrigin::kKnown);
  EXPECT_EQ(back.camera.model, CameraModel::kBrown);
  EXPECT_EQ(back.camera.fx, view.camera.fx);
  EXPECT_EQ(back.camera.distortion, view.camera.distortion);
  EXPECT_EQ(back.camera_from_world->rotation.coeffs(), view.camera_from_world->rotation.coeffs());
  EXPECT_EQ(back.camera_from_world->translation, view.camera_from_world->translation);
  EXPECT_EQ(back.grid, view.grid);
  std::string text = ReadAll(folder / "capture/capture.json");
  text.replace(text.find("\"format_version\": 1"), 19, "\"format_version\": 9");
  WriteText(folder / "capture/capture.json", text);
  EXPECT_THROW(LoadCapture(Workspace(folder)), Error);
}

}  // namespace
}  // namespace lamella
