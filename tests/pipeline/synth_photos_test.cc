#include "pipeline/synth_photos.h"

#include <atomic>
#include <functional>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kPhotographedDisplay = R"(
name = "tiny"
viewing_distance_mm = 300
[panel]
width_px = 36
height_px = 24
pitch_mm = 0.5
[[layer]]
position_mm = 0
d0_mm = 4
[layer.barrier]
period_px = 6
aperture_px = 2
slots = 3
)";

constexpr const char* kShots = R"({"format_version": 1, "shots": [
  {"name": "white", "layers": [{"emitter": ["white"]}]},
  {"name": "mark", "layers": [{"emitter": ["mark.png", "black"], "modulator": ["white"]}]}]})";

// The display, its shots and a mark in the top left of the panel, in a folder.
fs::path Folder() {
  fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "tiny.toml", kPhotographedDisplay);
  WriteTextAtomically(folder / "shots.json", kShots);
  Image<Rgb8> mark(36, 24);
  for (int v = 2; v < 6; ++v) {
    for (int u = 3; u < 9; ++u) mark(u, v) = {255, 0, 0};
  }
  WriteCodes8(folder / "mark.png", mark.span());
  return folder;
}

SynthPhotosOptions OptionsOf(const fs::path& folder) {
  SynthPhotosOptions options;
  options.display = (folder / "tiny.toml").string();
  options.shots = (folder / "shots.json").string();
  options.eyes = "0,0,300";
  options.samples = 16;
  return options;
}

TEST(SynthPhotos, WritesPhotographsWithTheirTruth) {
  const fs::path folder = Folder(), out = folder / "out";
  EXPECT_EQ(SynthPhotos(OptionsOf(folder), out, SilentProgress()), 2);
  const Image<Rgb> white = ReadImage(out / "images/eye_001_white.png");
  EXPECT_EQ(white.width(), 36);
  EXPECT_NEAR(white(20, 10).g, 0.8, 0.005);  // of patterns: clear of full scale
  // Upright: the mark is at the top left, red, and half as bright for its slot's half of the time.
  const Image<Rgb> mark = ReadImage(out / "images/eye_001_mark.png");
  EXPECT_NEAR(mark(6, 4).r, 0.4, 0.01);
  EXPECT_EQ(mark(6, 4).g, 0);
  EXPECT_EQ(mark(29, 4).r, 0);
  EXPECT_EQ(mark(6, 19).r, 0);
  const TransformsJson transforms = ReadTransformsJson(out / "transforms.json");
  ASSERT_EQ(transforms.views.size(), 2U);
  EXPECT_LT((Centre(transforms.views[1].camera_from_world) - Eigen::Vector3d(0, 0, 300)).norm(),
            1e-9);
  const Calibration truth = LoadCalibration(out / "calibration.json");
  EXPECT_EQ(truth.display, "tiny");
  EXPECT_EQ(truth.layers[0].gap_mm, 4);
  EXPECT_THAT(ReadText(out / "photos.json"), HasSubstr("\"shot\": \"mark\""));
}

TEST(SynthPhotos, MovesWithTheMisalignment) {
  const fs::path folder = Folder();
  SynthPhotosOptions options = OptionsOf(folder);
  SynthPhotos(options, folder / "design", SilentProgress());
  Calibration truth = LoadCalibration(folder / "design/calibration.json");
  truth.layers[0].offset_mm = {2.0, 0};  // 4 px of the emitter
  SaveCalibration(folder / "true.json", truth);
  options.misalignment = (folder / "true.json").string();
  SynthPhotos(options, folder / "moved", SilentProgress());
  const Image<Rgb> before = ReadImage(folder / "design/images/eye_001_mark.png");
  const Image<Rgb> after = ReadImage(folder / "moved/images/eye_001_mark.png");
  EXPECT_GT(before(4, 4).r, 0.3F);
  EXPECT_EQ(after(4, 4).r, 0);
  EXPECT_GT(after(10, 4).r, 0.3F);
}

TEST(SynthPhotos, RepeatsItsBytesForAnyNumberOfThreads) {
  const fs::path folder = Folder();
  SynthPhotosOptions options = OptionsOf(folder);
  options.eyes = "";
  options.views = 2;
  options.width_px = 64;
  options.distance_mm = 400;
  options.full_well_e = 5000;
  options.read_noise_e = 3;
  options.bits = 12;
  options.aperture_mm = 8;
  options.focus_mm = 380;
  std::vector<std::string> bytes;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    const fs::path out = folder / std::to_string(threads);
    EXPECT_EQ(SynthPhotos(options, out, SilentProgress()), 4);
    bytes.push_back(ReadText(out / "images/view_001_white.png") +
                    ReadText(out / "images/view_002_mark.png") + ReadText(out / "photos.json"));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_EQ(ReadImageInfo(folder / "1/images/view_001_white.png").bits, 16);
}

// Stops a run when so many rows of its photographs were exposed.
class Stopping : public Progress {
 public:
  explicit Stopping(std::int64_t rows) : rows_(rows) {}
  void Start(std::string_view, std::int64_t, std::string_view) override {}
  void Advance(std::int64_t units) override {
    if ((rows_ -= units) < 0) throw std::runtime_error("stopped");
  }
  void Note(std::string_view line) override { notes += line; }
  void Warn(std::string_view) override {}
  std::string notes;

 private:
  std::atomic<std::int64_t> rows_;
};

TEST(SynthPhotos, GoesOnWhereItWasStopped) {
  const fs::path folder = Folder(), whole = folder / "whole", out = folder / "out";
  SynthPhotosOptions options = OptionsOf(folder);
  options.eyes = "0,0,300;20,0,300";
  options.full_well_e = 5000;
  SynthPhotos(options, whole, SilentProgress());
  EXPECT_FALSE(fs::exists(whole / "unfinished.json"));
  Stopping stopping(2 * 24 + 4);  // in the second eye's two photographs
  EXPECT_THROW(SynthPhotos(options, out, stopping), std::runtime_error);
  EXPECT_FALSE(fs::exists(out / "photos.json"));
  const fs::path first = out / "images/eye_001_white.png";
  const auto written = fs::last_write_time(first);
  Stopping going_on(100000);
  EXPECT_EQ(SynthPhotos(options, out, going_on), 4);
  EXPECT_THAT(going_on.notes, HasSubstr("2 photographs of a run that was stopped are kept"));
  EXPECT_EQ(fs::last_write_time(first), written);
  for (const auto& file : fs::recursive_directory_iterator(whole)) {
    if (file.is_directory()) continue;
    const fs::path name = fs::relative(file.path(), whole);
    EXPECT_EQ(ReadText(out / name), ReadText(file.path())) << name;
  }
  EXPECT_FALSE(fs::exists(out / "unfinished.json"));
}

TEST(SynthPhotos, KeepsNoPhotographsOfSomethingElse) {
  const fs::path folder = Folder(), out = folder / "out";
  SynthPhotosOptions options = OptionsOf(folder);
  options.eyes = "0,0,300;20,0,300";
  Stopping stopping(2 * 24 + 4);
  EXPECT_THROW(SynthPhotos(options, out, stopping), std::runtime_error);
  // One of the shown images is another one now.
  WriteCodes8(folder / "mark.png", Image<Rgb8>(36, 24, Rgb8{255, 255, 255}).span());
  Stopping going_on(100000);
  SynthPhotos(options, out, going_on);
  EXPECT_EQ(going_on.notes, "");
  EXPECT_NEAR(ReadImage(out / "images/eye_001_mark.png")(29, 19).r, 0.4, 0.01);
}

// A folder of photographs of A, a run for B that is stopped, and B again: none of A's are left.
TEST(SynthPhotos, KeepsNoPhotographsOfAnEarlierRun) {
  const fs::path folder = Folder(), out = folder / "out", whole = folder / "whole";
  SynthPhotosOptions options = OptionsOf(folder);
  options.eyes = "0,0,300;20,0,300";
  SynthPhotos(options, out, SilentProgress());
  options.samples = 4;
  Stopping stopping(2 * 24 + 4);
  EXPECT_THROW(SynthPhotos(options, out, stopping), std::runtime_error);
  EXPECT_FALSE(fs::exists(out / "photos.json"));
  EXPECT_FALSE(fs::exists(out / "images/eye_002_mark.png"));
  SynthPhotos(options, out, SilentProgress());
  SynthPhotos(options, whole, SilentProgress());
  for (const auto& file : fs::directory_iterator(whole / "images")) {
    EXPECT_EQ(ReadText(out / "images" / file.path().filename()), ReadText(file.path()));
  }
}

TEST(SynthPhotos, RefusesWithOneLine) {
  const fs::path folder = Folder();
  const auto refusal = [&](const std::function<void(SynthPhotosOptions&)>& change) {
    SynthPhotosOptions options = OptionsOf(folder);
    change(options);
    try {
      SynthPhotos(options, folder / "out", SilentProgress());
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal([](auto& o) { o.eyes = ""; }), HasSubstr("no camera is given"));
  EXPECT_THAT(refusal([](auto& o) { o.views = 3; }), HasSubstr("several ways"));
  EXPECT_THAT(refusal([](auto& o) { o.eyes = "0,0"; }), HasSubstr("give X,Y,Z in mm"));
  EXPECT_THAT(refusal([](auto& o) { o.eyes = "0,0,-300"; }), HasSubstr("not in front of z = 0"));
  EXPECT_THAT(refusal([](auto& o) { o.raster = "1,2"; }), HasSubstr("LEFT,TOP"));
  EXPECT_THAT(refusal([](auto& o) { o.shots = ""; }), HasSubstr("--frames and --shots"));
  EXPECT_THAT(refusal([](auto& o) { o.display = ""; }), HasSubstr("give --display"));
  EXPECT_THAT(refusal([](auto& o) { o.aperture_mm = 2; }), HasSubstr("has no --focus-mm"));
  EXPECT_THAT(refusal([](auto& o) { o.misalignment = "nowhere.json"; }), HasSubstr("nowhere.json"));
  const auto shots = [&](const std::string& text) {
    WriteTextAtomically(folder / "bad.json", text);
    return refusal([&](auto& o) { o.shots = (folder / "bad.json").string(); });
  };
  EXPECT_THAT(shots(R"({"format_version": 2, "shots": []})"), HasSubstr("newer"));
  EXPECT_THAT(shots(R"({"format_version": 1, "shots": []})"), HasSubstr("one or more"));
  EXPECT_THAT(shots(R"({"format_version": 1, "shots": [{"name": "a", "layers": []}]})"),
              HasSubstr("is of 0 layers, the display has 1"));
  EXPECT_THAT(shots(R"({"format_version": 1, "shots": [{"name": "a", "layers": [{}]},
                                                       {"name": "a", "layers": [{}]}]})"),
              HasSubstr("the name of two photographs"));
  EXPECT_THAT(
      shots(R"({"format_version": 1, "shots": [{"name": "a", "layers": [{"emiter": []}]}]})"),
      HasSubstr("did you mean \"emitter\""));
  EXPECT_THAT(
      shots(
          R"({"format_version": 1, "shots": [{"name": "a", "layers": [{"emitter": ["no.png"]}]}]})"),
      HasSubstr("no.png"));
}

}  // namespace
}  // namespace lamella
