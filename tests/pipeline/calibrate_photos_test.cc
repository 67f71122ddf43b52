// Patterns on a virtual prototype, photographed, checked and read: corners and nodes against the
// lines of sight of the prototype's own numbers.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/check_photos.h"
#include "pipeline/observe_photos.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A small display, 80 mm wide: of 160 x 120 px, or of half as many.
std::string DisplayOf(int binning) {
  return fmt::format(R"(
name = "small"
viewing_distance_mm = 400
[panel]
width_px = {}
height_px = {}
pitch_mm = {}
[[layer]]
position_mm = 0
d0_mm = 4
mirror_x = true
[layer.barrier]
period_px = 5
aperture_px = 1
slots = 5
)",
                     160 / binning, 120 / binning, 0.5 * binning);
}

// Patterns, and photographs of them from one place, a little out of focus, 2 px per panel px. Edges
// need more lines of sight a pixel than sinusoids.
fs::path PhotographedBy(CalibrationMode mode, int binning, int samples) {
  fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "small.toml", DisplayOf(binning));
  WritePatterns(folder / "patterns",
                PlanShots(DesignCalibration(ReadDisplay(folder / "small.toml")), mode),
                SilentProgress());
  SynthPhotosOptions options;
  options.display = (folder / "small.toml").string();
  options.shots = (folder / "patterns/shots.json").string();
  options.eyes = "25,10,390";
  options.raster = fmt::format("-44,34,{},{},{}", 0.25 * binning, 352 / binning, 272 / binning);
  options.samples = samples;
  options.aperture_mm = 3;
  options.focus_mm = 310;
  options.full_well_e = 20000;
  options.read_noise_e = 3;
  options.exposure = 0.8;
  options.bits = 12;
  SynthPhotos(options, folder / "taken", SilentProgress());
  return folder;
}

// Where the camera sees a panel's pixel: air gaps only, so along straight lines.
Vector2d Truth(const fs::path& taken, const PanelId& id, const Vector2d& panel_px) {
  const LayerCalibration layer =
      LoadCalibration(taken / "calibration.json").layers[static_cast<std::size_t>(id.layer)];
  const bool emits = id.role == PanelId::kEmitter;
  const PanelCalibration& panel = emits ? layer.emitter : *layer.modulator;
  const Vector3d at(
      (panel.mirror_x ? -1 : 1) * panel.pitch_mm * (panel_px.x() - panel.width_px / 2.0),
      panel.pitch_mm * (panel.height_px / 2.0 - panel_px.y()), emits ? -layer.gap_mm : 0);
  const View view = ReadTransformsJson(taken / "transforms.json").views.front();
  return *Project(view.camera, view.camera_from_world * (layer.display_from_stack * at));
}

double RmsOf(const fs::path& taken, const PanelPhoto& photo) {
  double sum = 0;
  for (const Observation& point : photo.points) {
    sum += (point.image_px - Truth(taken, photo.panel, point.panel_px)).squaredNorm() / 2;
  }
  return std::sqrt(sum / static_cast<double>(photo.points.size()));
}

TEST(CalibratePhotos, FindsBoardsWhereThePrototypeShowsThem) {
  const fs::path folder = PhotographedBy(CalibrationMode::kQuick, 1, 64);
  std::string report;
  const CheckedPhotos checked = CheckPhotos(
      folder / "patterns", folder / "taken/images",
      [&](const CheckedPhoto& photo, const std::string& shot) {
        report += photo.photo + " " + shot + ": " + photo.verdict + "\n";
      },
      SilentProgress());
  EXPECT_THAT(checked.missing, IsEmpty()) << report;
  EXPECT_EQ(checked.num_views, 1);
  EXPECT_THAT(report, HasSubstr("eye_001_06_layer0_modulator_board_again.png "
                                "06_layer0_modulator_board_again: good: moved by 0.0"));
  const Observations seen = ObservePhotos(checked, folder / "taken/images", SilentProgress());
  ASSERT_EQ(seen.photos.size(), 2U);
  for (const PanelPhoto& photo : seen.photos) {
    EXPECT_EQ(photo.points.size(), 3U * 2) << NameOf(photo.panel);
    EXPECT_LT(RmsOf(folder / "taken", photo), 0.05) << NameOf(photo.panel);
  }
}

TEST(CalibratePhotos, DecodesSinusoidsWhereThePrototypeShowsThem) {
  const fs::path folder = PhotographedBy(CalibrationMode::kPrecise, 2, 16);
  const CheckedPhotos checked = CheckPhotos(
      folder / "patterns", folder / "taken/images", [](const auto&, const auto&) {},
      SilentProgress());
  EXPECT_THAT(checked.missing, IsEmpty());
  const Observations seen = ObservePhotos(checked, folder / "taken/images", SilentProgress());
  ASSERT_EQ(seen.photos.size(), 2U);
  for (const PanelPhoto& photo : seen.photos) {
    EXPECT_GT(photo.points.size(), 200U) << NameOf(photo.panel);
    EXPECT_LT(RmsOf(folder / "taken", photo), 0.01) << NameOf(photo.panel);
  }
}

// Two positions of one board each, then the first board again.
CheckedPhotos TwoPositions(double first_moved_px, double second_moved_px) {
  CheckedPhotos checked;
  checked.list.panels = {{{0, PanelId::kEmitter}, {100, 100}, false, std::nullopt}};
  const PatternShot board{"1_board", PatternShot::Kind::kBoard, {0, PanelId::kEmitter}, {}, false};
  PatternShot again = board;
  again.again = true;
  checked.list.shots = {board, again};
  checked.num_views = 2;
  for (int view = 0; view < 2; ++view) {
    CheckedPhoto photo{fmt::format("{}.png", view), view, 0, true, true, "good", std::nullopt, {}};
    photo.facts.width = photo.facts.height = 200;
    photo.facts.sighting = BoardSighting{};
    photo.facts.sighting->points = {{{10, 10}, {20, 20}, Eigen::Matrix2d::Identity()}};
    checked.photos.push_back(photo);
    photo.shot = 1;
    photo.moved_px = view == 0 ? first_moved_px : second_moved_px;
    photo.good = *photo.moved_px < 0.05;
    photo.usable = false;
    checked.photos.push_back(photo);
  }
  return checked;
}

TEST(CalibratePhotos, LeaveOutPositionsWhereTheCameraMoved) {
  EXPECT_EQ(ObservePhotos(TwoPositions(0.01, 0.02), ".", SilentProgress()).photos.size(), 2U);
  const CheckedPhotos moved = TwoPositions(0.3, 0.02);
  ASSERT_EQ(MovedPositions(moved).size(), 1U);
  EXPECT_EQ(MovedPositions(moved)[0].view, 0);
  EXPECT_EQ(MovedPositions(moved)[0].moved_px, 0.3);
  const Observations seen = ObservePhotos(moved, ".", SilentProgress());
  ASSERT_EQ(seen.photos.size(), 1U);
  EXPECT_EQ(seen.photos[0].view, 1);
  try {
    ObservePhotos(TwoPositions(0.3, 0.1), "taken", SilentProgress());
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_THAT(error.what(), HasSubstr("taken: the camera moved at every position"));
  }
}

TEST(CalibrationPatterns, ReadBackAsTheyWereWritten) {
  const fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "small.toml", DisplayOf(1));
  const ShotList list =
      PlanShots(DesignCalibration(ReadDisplay(folder / "small.toml")), CalibrationMode::kPrecise);
  WritePatterns(folder, list, SilentProgress());
  const ShotList read = LoadShotList(folder);
  EXPECT_EQ(read.display, "small");
  EXPECT_EQ(read.mode, CalibrationMode::kPrecise);
  ASSERT_EQ(read.panels.size(), 2U);
  EXPECT_EQ(read.panels[1].board, list.panels[1].board);
  EXPECT_TRUE(read.panels[1].mirrored);
  ASSERT_EQ(read.shots.size(), list.shots.size());
  for (std::size_t i = 0; i < read.shots.size(); ++i) {
    EXPECT_EQ(read.shots[i].name, list.shots[i].name);
    EXPECT_EQ(read.shots[i].kind, list.shots[i].kind);
    EXPECT_EQ(read.shots[i].panel, list.shots[i].panel);
    EXPECT_EQ(read.shots[i].pattern, list.shots[i].pattern);
    EXPECT_EQ(read.shots[i].again, list.shots[i].again);
  }
  const Image<Rgb8> board = ReadSrgb8(folder / "layer0_emitter_board.png");
  EXPECT_EQ(board.width(), 160);
  EXPECT_THAT(ReadText(folder / "shots.txt"), HasSubstr("layer 0 modulator: board"));
}

TEST(CalibrationPatterns, AreRefusedWithOneLineWhereTheyAreNotWhole) {
  const fs::path folder = ScratchFolder();
  const auto refusal = [&](const std::string& text) {
    WriteTextAtomically(folder / "patterns.json", text);
    try {
      LoadShotList(folder);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("{}"), HasSubstr("format_version"));
  EXPECT_THAT(refusal(R"({"format_version": 2})"), HasSubstr("newer"));
  const std::string head =
      R"({"format_version": 1, "display": "d", "mode": "quick", "num_layers": 1, )";
  EXPECT_THAT(refusal(head + R"("panels": [], "shots": []})"), HasSubstr("shots"));
  EXPECT_THAT(refusal(head + R"("panels": [], "shots": [{"name": "a", "kind": "x"}]})"),
              HasSubstr("kind"));
  EXPECT_THAT(
      refusal(head + R"("panels": [], "shots": [{"name": "a", "kind": "white", "layer": 0}]})"),
      HasSubstr("role"));
  EXPECT_THROW(LoadShotList(folder / "nowhere"), Error);
}

}  // namespace
}  // namespace lamella
