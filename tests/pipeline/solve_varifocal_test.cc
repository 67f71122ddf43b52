// Planes of a misaligned virtual prototype, each lit alone with sinusoids, photographed, decoded
// lens by lens and calibrated; the display's ray map then is that of the planes as they are.
#include "pipeline/solve_varifocal.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets_synthetic/cameras.h"
#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/photo_cameras.h"
#include "pipeline/report/varifocal_page.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kDisplay = R"(
name = "small-varifocal"
viewing_distance_mm = 400
shear = false
[panel]
width_px = 117
height_px = 101
pitch_mm = 0.4
[varifocal]
planes = 2
depth_mm = 40
relay_focal_mm = 500
[[layer]]
d0_mm = 5
[layer.lenslets]
lattice = "hexagonal"
pitch_px = 9
rays = 4
)";

// What the relay really does: planes off their places, larger with all that goes with it.
Calibration Misaligned(const Calibration& design) {
  Calibration truth = design;
  for (std::size_t k = 0; k < truth.layers.size(); ++k) {
    LayerCalibration& layer = truth.layers[k];
    const double larger = k == 0 ? 1.01 : 0.99;
    layer.display_from_stack.rotation =
        Eigen::AngleAxisd(0.01, Vector3d(1, k == 0 ? 1 : -1, 0.5).normalized());
    layer.display_from_stack.translation += Vector3d(0.6, -0.4, k == 0 ? 1 : -0.8);
    layer.emitter.scale = (1 + layer.emitter.scale) * larger - 1;
    MagnifyOptics(layer, larger);
  }
  return truth;
}

// Photographs from four places within 9 degrees of the axis.
void Photograph(const fs::path& folder) {
  SynthPhotosOptions options;
  options.misalignment = (folder / "truth.json").string();
  options.shots = (folder / "patterns/shots.json").string();
  options.eyes = "60,15,400;-60,-20,390;15,60,410;-15,-60,400";
  options.raster = "-27,23.2,0.4,135,116";
  options.samples = 2;
  options.blur_px = 0.7;
  options.exposure = 1.6;
  options.bits = 12;
  SynthPhotos(options, folder / "taken", SilentProgress());
}

// Where the beam of an emitter leaves, mm across.
std::optional<Eigen::Vector2d> ElementOf(const CalibratedMap& map, int column, int row) {
  const auto beam = map.BeamOf(0, 0, column, row);
  if (!beam) return std::nullopt;
  return Eigen::Vector2d(beam->beam.x.element_mm, beam->beam.y.element_mm);
}

TEST(SolveVarifocal, FindsThePlanesOfAMisalignedPrototype) {
  const fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "small.toml", kDisplay);
  const Display display = ReadDisplay(folder / "small.toml");
  const Calibration truth = Misaligned(DesignCalibration(display));
  SaveCalibration(folder / "truth.json", truth);
  WritePatterns(folder / "patterns",
                PlanShots(DesignCalibration(display), CalibrationMode::kPrecise, true),
                SilentProgress());
  EXPECT_TRUE(LoadShotList(folder / "patterns").planes_in_turn);
  Photograph(folder);
  SolveVarifocalOptions options;
  options.photos.patterns = folder / "patterns";
  options.photos.photos = folder / "taken/images";
  options.photos.display = (folder / "small.toml").string();
  EXPECT_THROW(SolveVarifocalPhotos(options, SilentProgress()), Error);  // no poses
  options.cameras = folder / "taken/transforms.json";
  const SolvedVarifocal solved = SolveVarifocalPhotos(options, SilentProgress());
  const VarifocalReport& report = solved.report;
  ASSERT_EQ(report.planes.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const CalibratedPlane& plane = report.planes[k];
    const double depth = plane.display_from_plane.translation.z() -
                         truth.layers[k].display_from_stack.translation.z();
    const double magnification = plane.magnification - 1 - truth.layers[k].emitter.scale;
    fmt::print(
        "plane {}: depth off by {:.4f} mm (sd {:.4f}), magnification by {:.1e} (sd {:.1e})\n", k,
        depth, plane.depth_sd_mm, magnification, plane.magnification_sd);
    EXPECT_LT(std::abs(depth), 4 * plane.depth_sd_mm);
    EXPECT_LT(std::abs(magnification), 4 * plane.magnification_sd);
    EXPECT_LT(plane.depth_sd_mm, 0.1);
    EXPECT_LT(plane.magnification_sd, 5e-4);
  }
  // It is read back with what it is worth.
  SaveCalibration(folder / "found.json", report.calibration, {MeasurementOf(solved), {}});
  EXPECT_EQ(LoadCalibration(folder / "found.json").layers[1].emitter.scale,
            report.calibration.layers[1].emitter.scale);
  const auto measured = LoadMeasurement(folder / "found.json");
  ASSERT_TRUE(measured);
  EXPECT_FALSE(measured->reference);
  ASSERT_EQ(measured->deviations.size(), 14U);
  EXPECT_EQ(measured->deviations[12].name, "plane 1 depth");
  EXPECT_EQ(measured->deviations[12].sd, report.planes[1].depth_sd_mm);
  EXPECT_GT(measured->ray_max_sd_px, measured->ray_rms_sd_px);
  // Layers are made by it: beams of the calibrated map are those of the truth.
  CheckCalibrates(report.calibration, display, "calibration");
  double worst_calibrated = 0, worst_designed = 0;  // mm, where light leaves the lenses
  for (int layer = 0; layer < 2; ++layer) {
    const CalibratedMap is(display, report.calibration, layer), should(display, truth, layer);
    const CalibratedMap designed(display, DesignCalibration(display), layer);
    for (int i = 0; i < 117 * 101; i += 7) {
      const auto a = ElementOf(is, i % 117, i / 117), b = ElementOf(should, i % 117, i / 117),
                 c = ElementOf(designed, i % 117, i / 117);
      if (!a || !b || !c) continue;
      worst_calibrated = std::max(worst_calibrated, (*a - *b).norm());
      worst_designed = std::max(worst_designed, (*c - *b).norm());
    }
  }
  EXPECT_GT(worst_designed, 0.5);
  EXPECT_LT(worst_calibrated, 0.05);
  EXPECT_THAT(DescribeVarifocal(solved), HasSubstr("planes: z mm, magnification"));
  // The page says how well each plane is known, here not well enough.
  const std::string page = VarifocalPage(solved);
  EXPECT_FALSE(report.accepted());
  EXPECT_THAT(page, HasSubstr("Not certain enough for a calibration."));
  for (const CalibratedPlane& plane : report.planes) {
    EXPECT_THAT(page,
                HasSubstr(fmt::format("{:.4f} ± {:.4f}", plane.display_from_plane.translation.z(),
                                      plane.depth_sd_mm)));
  }
  EXPECT_THAT(page, HasSubstr(report.next_view ? "help most, " + DescribeNextPlaneView(report)
                                               : "Orange ring: none"));
  int points = 0;
  for (const ResidualCell& cell : Pooled(report.residuals).cells) points += cell.num_points;
  EXPECT_EQ(points, report.planes_fit[0].num_used + report.planes_fit[1].num_used);
}

constexpr const char* kBoardPlace = "77,3,-4,1.5,-1,0.7";  // where it is fixed

// The planes before two cameras, a board of 7 x 5 squares beside them before these and six more.
class PlanesBesideBoard {
 public:
  PlanesBesideBoard() : folder_(ScratchFolder()) {
    WriteTextAtomically(folder_ / "small.toml", kDisplay);
    const Display display = ReadDisplay(folder_ / "small.toml");
    const Calibration design = DesignCalibration(display);
    truth_ = Misaligned(design);
    SaveCalibration(folder_ / "truth.json", truth_);
    ShotList list = WithPrintedBoard(PlanShots(design, CalibrationMode::kPrecise, true));
    list.printed = PrintedBoard{{7 * 35 + 20, 5 * 35 + 20, 7, 5, 35, 10, 10, 900}, 12};
    WritePatterns(folder_ / "patterns", list, SilentProgress());
    WriteTextAtomically(folder_ / "patterns" / kPatternsDisplay, ToToml(display));
    WriteCameras();
    ShotList board = list, dark = list, planes = list;
    board.shots = {list.shots.back()};
    dark.shots = {list.shots.front()};
    planes.shots.pop_back();
    Photograph(planes, "near.json", 1);
    Photograph(dark, "around.json", 1);
    Photograph(board, "near.json", 4);
    Photograph(board, "around.json", 4);
  }

  SolveVarifocalOptions Options() const {
    SolveVarifocalOptions options;
    options.photos.patterns = folder_ / "patterns";
    options.photos.photos = folder_ / "all";
    return options;
  }

  const Calibration& truth() const { return truth_; }
  Rigid place() const { return PlaceOfPrintedBoard(kBoardPlace).value(); }

 private:
  static void AddCamera(const Vector3d& eye, const Vector3d& target, TransformsJson& to, int n) {
    View view;
    view.name = fmt::format("camera_{:02}", n);
    view.image = view.name + ".png";
    view.camera.width = 470;
    view.camera.height = 236;
    view.camera.fx = view.camera.fy = 1160;
    view.camera.cx = 233;
    view.camera.cy = 121;
    view.camera_from_world = LookAt(eye, target, {0, 1, 0});
    to.views.push_back(view);
  }

  void WriteCameras() {
    TransformsJson near, around;
    AddCamera({60, 35, 400}, {48, 0, 0}, near, 1);
    AddCamera({-60, -30, 390}, {48, 0, 0}, near, 2);
    const Vector3d board = place().translation;
    int n = 3;
    for (const Eigen::Vector2d& side :
         {Eigen::Vector2d(-170, 0), Eigen::Vector2d(170, 0), Eigen::Vector2d(0, -170),
          Eigen::Vector2d(0, 170), Eigen::Vector2d(120, 120), Eigen::Vector2d(-120, 120)}) {
      AddCamera(board + Vector3d(side.x(), side.y(), 280), board, around, n++);
    }
    WriteTransformsJson(folder_ / "near.json", near);
    WriteTransformsJson(folder_ / "around.json", around);
  }

  void Photograph(const ShotList& list, const char* cameras, int samples) {
    WritePatterns(folder_ / "shown", list, SilentProgress());
    SynthPhotosOptions options;
    options.misalignment = (folder_ / "truth.json").string();
    options.shots = (folder_ / "shown/shots.json").string();
    options.cameras = (folder_ / cameras).string();
    options.printed_board = kBoardPlace;
    options.samples = samples;
    options.blur_px = 0.7;
    options.exposure = list.shots.front().kind == PatternShot::Kind::kPrinted ? 0.3 : 1.6;
    options.bits = 12;
    SynthPhotos(options, folder_ / "taken", SilentProgress());
    fs::create_directories(folder_ / "all");
    for (const auto& file : fs::directory_iterator(folder_ / "taken/images")) {
      std::string name = file.path().stem().string();
      if (list.shots.size() == 1) name += "_" + list.shots[0].name;  // which is left out then
      fs::rename(file.path(), folder_ / "all" / (name + ".png"));
    }
  }

  fs::path folder_;
  Calibration truth_;
};

TEST(SolveVarifocal, FindsThePlanesByAPrintedBoardBesideThem) {
  const PlanesBesideBoard scene;
  const SolvedVarifocal solved = SolveVarifocalPhotos(scene.Options(), SilentProgress());
  const VarifocalReport& report = solved.report;
  EXPECT_THAT(solved.left_out, IsEmpty());
  EXPECT_EQ(solved.doubtful.size(), 8U);  // its squares are small
  EXPECT_EQ(report.camera_from_display.size(), 8U);
  ASSERT_EQ(report.planes.size(), 2U);
  const Rigid true_from_found = scene.place() * Inverse(report.display_from_frame);
  for (std::size_t k = 0; k < 2; ++k) {
    const CalibratedPlane& plane = report.planes[k];
    const LayerCalibration& truth = scene.truth().layers[k];
    const Vector3d off = (true_from_found * plane.display_from_plane).translation -
                         truth.display_from_stack.translation;
    const double magnification = plane.magnification - 1 - truth.emitter.scale;
    fmt::print(
        "plane {}: off by ({:.4f}, {:.4f}, {:.4f}) mm (depth sd {:.4f}), magnification by "
        "{:.1e} (sd {:.1e})\n",
        k, off.x(), off.y(), off.z(), plane.depth_sd_mm, magnification, plane.magnification_sd);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(off(axis)), 4 * std::sqrt(plane.covariance(3 + axis, 3 + axis)));
    }
    EXPECT_LT(std::abs(magnification), 4 * plane.magnification_sd);
    EXPECT_LT(plane.depth_sd_mm, 0.3);
    EXPECT_LT(plane.magnification_sd, 1e-3);
  }
  EXPECT_THAT(VarifocalPage(solved), HasSubstr("(hollow: no plane is seen from there)"));
}

}  // namespace
}  // namespace lamella
