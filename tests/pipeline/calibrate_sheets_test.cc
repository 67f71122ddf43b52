// Sinusoids on a virtual prototype with a lens sheet that is not the designed one, photographed and
// solved: against the prototype's own numbers, its lines of sight and the visual.json of them.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/lattice_place.h"
#include "datasets_synthetic/cameras.h"
#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/calibrated_sheet.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/photo_cameras.h"
#include "pipeline/report/sheets_page.h"
#include "pipeline/sheet_sights.h"
#include "pipeline/solve_sheets.h"
#include "pipeline/synth_photos.h"
#include "tests/calibration/sheet_scene.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kDisplay = R"(
name = "sheet"
viewing_distance_mm = 300
[panel]
width_px = 96
height_px = 72
pitch_mm = 0.4
[[layer]]
position_mm = 0
d0_mm = 4
)";
constexpr const char* kSlanted = R"([layer.lenticular]
subpixels_per_lens = 14.1
slant = 0.1667
views = 9
)";
constexpr const char* kHexagonal = R"([layer.lenslets]
lattice = "hexagonal"
pitch_px = 6.3
rays = 5
)";

// The sheet as it was made: half a percent wide, a quarter of a degree askew, shifted, thick, and
// the panel behind it not where it was to be.
Calibration Built(const Display& display) {
  Calibration built = DesignCalibration(display);
  LayerCalibration& layer = built.layers[0];
  LensLattice lattice = layer.lattice.value();
  lattice.pitch_mm *= 1.006;
  lattice.rotation_rad += 0.0045;
  lattice.phase += Vector2d(0.37, lattice.type == LensLattice::Type::kLine ? 0 : 0.21);
  lattice.phase.array() -= lattice.phase.array().floor();
  layer.lattice = lattice;
  layer.gap_mm *= 1.05;
  layer.offset_mm = {1.3, -0.8};
  layer.rotation_rad = {0, 0, 0.004};
  return built;
}

// What a printed board beside a sheet says, and what the sheet is then known to.
struct BoardTrial {
  double error_rms_px = 0, sd_rms_px = 0;
};

// Two cameras see the sheet and the board, six more the board; corners and decoded pixels are off.
class BoardScene {
 public:
  explicit BoardScene(double corner_px) : corner_px_(corner_px) {
    camera_.model = CameraModel::kBrown;
    camera_.width = 3000;
    camera_.height = 2000;
    camera_.fx = 3300;
    camera_.fy = 3310;
    camera_.cx = 1520;
    camera_.cy = 985;
    camera_.distortion[0] = -0.08;
    for (const Vector3d& eye : TwoEyes()) eyes_.push_back(eye);
    for (const Vector2d& side : {Vector2d(-1, 0), Vector2d(1, 0), Vector2d(0, -1), Vector2d(0, 1),
                                 Vector2d(1, 1), Vector2d(-1, 1)}) {
      eyes_.emplace_back(140 + 250 * side.x(), 250 * side.y(), 420);
    }
    printed_ = BoardToPrint();
    printed_.square_mm = 9;
    display_from_board_ = {Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Vector3d(1, -0.5, 0.2))),
                           Vector3d(140, 12, -3)};
    display_from_board_.rotation.normalize();
  }

  BoardTrial Try(std::uint32_t seed) {
    random_.seed(seed);
    const BoardCameras board = CamerasOfBoard(PhotographBoard(), {"body", 3000, 2000, 0}, printed_);
    EXPECT_THAT(board.failures, IsEmpty());
    EXPECT_NEAR(board.rms_px, std::sqrt(2.0) * corner_px_, 0.15 * corner_px_);
    SightedPixels pixels = PhotographPanel();
    std::vector<View> views(2);
    for (std::size_t i = 0; i < 2; ++i) {
      views[i].camera = board.found.camera;
      views[i].camera_from_world = board.found.camera_from_board[i];
    }
    const LayerCalibration design = DesignOf(sheet_);
    const Rigid stack_from_board = StackFromFrame(Through(pixels, views, Rigid{}), design);
    const LatticeObservations seen = Through(pixels, views, stack_from_board);
    LatticeOptions options = SheetViewers();
    options.eye_sd_mm = 0;
    options.camera_errors = ErrorsOf(board, pixels, {0, 1}, seen, stack_from_board);
    const LatticeReport report = EstimateLattice(seen, WithPanelInPlace(seen, design), options);
    return {ErrorOf(report.layer, stack_from_board * Inverse(display_from_board_), options.eye_box),
            report.drift_rms_px};
  }

 private:
  Rigid CameraFromDisplay(std::size_t view) const {
    return LookAt(eyes_[view], {view < 2 ? 60.0 : 120.0, 0, 0}, {0.1, 1, 0});
  }

  std::vector<BoardPhoto> PhotographBoard() {
    std::normal_distribution<double> noise(0, corner_px_);
    std::vector<BoardPhoto> photos;
    for (std::size_t view = 0; view < eyes_.size(); ++view) {
      photos.push_back({static_cast<int>(view), fmt::format("board {}", view), {}});
      const Rigid camera_from_board = CameraFromDisplay(view) * display_from_board_;
      for (int c = 0; c < printed_.board.num_corners(); ++c) {
        const Vector2d px = printed_.board.CornerPx(c);
        const auto image = Project(camera_, camera_from_board * PanelPoint(PanelOf(printed_), px));
        photos.back().points.push_back({px,
                                        image.value() + Vector2d(noise(random_), noise(random_)),
                                        corner_px_ * corner_px_ * Eigen::Matrix2d::Identity()});
      }
    }
    return photos;
  }

  SightedPixels PhotographPanel() {
    std::uniform_real_distribution<double> side(-0.5, 0.5);
    std::normal_distribution<double> noise(0, 0.3);
    SightedPixels seen;
    for (int i = 0; i < 3000; ++i) {
      const std::size_t view = i % 2 == 0 ? 0 : 1;
      const Vector2d q(side(random_) * kSheetWidth * kSheetPixel,
                       side(random_) * kSheetHeight * kSheetPixel);
      const Vector2d shown = sheet_.Seen(q, eyes_[view]) / kSheetPixel;
      const auto image = Project(camera_, CameraFromDisplay(view) * Vector3d(q.x(), q.y(), 0));
      seen.pixels.push_back({static_cast<int>(view),
                             image.value(),
                             {kSheetWidth / 2.0 + shown.x() + noise(random_),
                              kSheetHeight / 2.0 - shown.y() + noise(random_)},
                             {0.3, 0.3}});
    }
    return seen;
  }

  // RMS over lenses at the panel's edges and eyes: what lines of sight of the true display meet,
  // against the found lattice in its own frame.
  double ErrorOf(const LayerCalibration& found, const Rigid& found_from_true,
                 const EyeBox& box) const {
    const LensLattice lattice = found.lattice.value();
    const Vector2d normal(std::cos(lattice.rotation_rad), std::sin(lattice.rotation_rad));
    double sum = 0;
    int count = 0;
    for (const Vector3d& eye : box.Eyes()) {
      for (int place = 0; place < 9; ++place) {
        const int column = place % 3 - 1, row = place / 3 - 1;
        const Vector2d q(column * kSheetWidth * kSheetPixel / 2,
                         row * kSheetHeight * kSheetPixel / 2);
        const Vector2d shown = sheet_.Seen(q, eye) / kSheetPixel;
        const Vector3d direction = found_from_true.rotation * (Vector3d(q.x(), q.y(), 0) - eye);
        const Vector3d at =
            StackFromEmitter(found) * PanelPoint(found.emitter, {kSheetWidth / 2.0 + shown.x(),
                                                                 kSheetHeight / 2.0 - shown.y()});
        const double s =
            normal.dot(at.head<2>() - found.gap_mm * direction.head<2>() / -direction.z()) /
                lattice.pitch_mm -
            lattice.phase.x();
        sum += std::pow((s - std::round(s)) * lattice.pitch_mm / kSheetPixel, 2);
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }

  double corner_px_;
  Sheet sheet_;
  Camera camera_;
  std::vector<Vector3d> eyes_;
  PrintedBoard printed_;
  Rigid display_from_board_;
  std::mt19937 random_;
};

// Of corners so bad that the cameras are what is not known.
TEST(CalibrateSheets, AreAsCertainAsTheBoardsCameras) {
  BoardScene scene(0.3);
  double errors2 = 0, sds2 = 0;
  constexpr int kTrials = 16;
  for (int trial = 0; trial < kTrials; ++trial) {
    const BoardTrial tried = scene.Try(static_cast<std::uint32_t>(trial));
    errors2 += tried.error_rms_px * tried.error_rms_px / kTrials;
    sds2 += tried.sd_rms_px * tried.sd_rms_px / kTrials;
  }
  fmt::print("sheet off by {:.4f} px rms, said to be {:.4f}\n", std::sqrt(errors2),
             std::sqrt(sds2));
  EXPECT_GT(errors2 / sds2, 0.7 * 0.7);
  EXPECT_LT(errors2 / sds2, 1.3 * 1.3);
}

struct Taken {
  fs::path folder;
  Calibration truth;
  SolveSheetsOptions options;
};

Taken Photographs(const char* optics, const std::string& eyes, bool faint = false) {
  Taken taken{ScratchFolder(), {}, {}};
  const fs::path& folder = taken.folder;
  WriteTextAtomically(folder / "sheet.toml", std::string(kDisplay) + optics);
  const Display display = ReadDisplay(folder / "sheet.toml");
  taken.truth = Built(display);
  SaveCalibration(folder / "truth.json", taken.truth);
  WritePatterns(folder / "patterns",
                PlanShots(DesignCalibration(display), CalibrationMode::kPrecise), SilentProgress());
  WriteTextAtomically(folder / "patterns" / kPatternsDisplay, ToToml(display));
  SynthPhotosOptions options;
  options.misalignment = (folder / "truth.json").string();
  options.shots = (folder / "patterns/shots.json").string();
  options.eyes = eyes;
  options.raster = "-21,16,0.2,210,160";
  options.samples = 4;
  options.full_well_e = 20000;
  options.read_noise_e = faint ? 290 : 3;
  options.exposure = faint ? 0.035 : 0.27;
  options.bits = 12;
  SynthPhotos(options, folder / "taken", SilentProgress());
  taken.options.patterns = folder / "patterns";
  taken.options.photos = folder / "taken/images";
  taken.options.cameras = folder / "taken/transforms.json";
  taken.options.camera_sd_mm = 0.1;
  return taken;
}

const LayerCalibration& LayerOf(const Calibration& calibration) { return calibration.layers[0]; }

// The rays of all emitters, where both calibrations make them for one lens: how far apart they are
// at the viewer, as px of the emitter behind the lens.
double LargestRayDifference(const Taken& taken, const Calibration& found) {
  const Display display = ReadDisplay(taken.folder / "sheet.toml");
  const CalibratedMap truth(display, taken.truth, 0), map(display, found, 0);
  const double D = display.viewing_distance_mm;
  const double per_px = D / LayerOf(taken.truth).gap_mm * display.pitch_mm;
  double most = 0;
  int compared = 0;
  for (int i = 0; i < display.width_px * display.height_px; ++i) {
    const int column = i % display.width_px, row = i / display.width_px;
    const auto a = truth.BeamOf(0, 1, column, row), b = map.BeamOf(0, 1, column, row);
    if (!a || !b) continue;
    const Vector2d off(a->beam.x.At(D) - b->beam.x.At(D), a->beam.y.At(D) - b->beam.y.At(D));
    if (off.norm() > 2 * per_px) continue;  // its light is made for the neighbouring lens
    ++compared;
    most = std::max(most, off.norm() / per_px);
  }
  EXPECT_GT(compared, 2000);
  return most;
}

TEST(CalibrateSheets, FindsSlantedLensesOfAVirtualPrototype) {
  const Taken taken = Photographs(kSlanted, "-70,20,310;60,-40,290");
  const SolvedSheets solved = SolveSheets(taken.options, SilentProgress());
  const std::string text = DescribeSheets(solved);
  EXPECT_THAT(solved.failures(), IsEmpty()) << text;
  EXPECT_THAT(text, HasSubstr("sheet: the calibration is certain enough\n"));
  ASSERT_EQ(solved.sheets.size(), 1U);
  EXPECT_EQ(solved.sheets[0].num_views, 2);
  EXPECT_EQ(solved.sheets[0].report.residuals.CellsSeen(), 40U);
  const std::string page = SheetsPage(solved);
  EXPECT_THAT(page, HasSubstr("Certain enough for a calibration."));
  EXPECT_THAT(page, HasSubstr(fmt::format("{:.4f} px at worst (0.02 asked for)",
                                          solved.sheets[0].report.drift_max_px)));
  EXPECT_THAT(page,
              HasSubstr(fmt::format(">{:.4f}</text>", solved.sheets[0].report.drift[8].rms_px)));
  EXPECT_THAT(page, HasSubstr("position 1: -12.7° to the right, 3.7° up"));
  EXPECT_NEAR(solved.calibration.layers[0].gap_mm, LayerOf(taken.truth).gap_mm, 0.03);
  EXPECT_LT(LargestRayDifference(taken, solved.calibration), 0.04);
  // As other programs weave by them, near and far.
  for (const double distance : {240.0, 300.0, 500.0}) {
    const SheetForViewer truth = SheetFor(LayerOf(taken.truth), distance, "truth");
    const SheetForViewer found = SheetFor(LayerOf(solved.calibration), distance, "found");
    for (int i = 0; i < 96 * 72 * 3; i += 5) {
      const int channel = i % 3, column = i / 3 % 96, row = i / 3 / 96;
      const double apart = LookingGlassView(truth.panel, column, row, channel) -
                           LookingGlassView(found.panel, column, row, channel);
      EXPECT_LT(std::abs(apart - std::round(apart)) * 4.7, 0.03) << column << " " << row;
    }
  }
  const fs::path file = taken.folder / "calibration.json";
  SaveCalibration(file, solved.calibration, {MeasurementOf(solved), {}});
  EXPECT_EQ(LoadCalibration(file).layers[0].lattice->phase,
            solved.calibration.layers[0].lattice->phase);
  const CalibrationMeasurement measured = LoadMeasurement(file).value();
  EXPECT_EQ(measured.photos.size(), 26U * 2);
  EXPECT_EQ(measured.deviations[0].name, "layer 0 lens pitch");
  EXPECT_LT(measured.ray_max_sd_px, 0.02);
}

// Few lenses, each of which shows one pixel: two hundred of them do not carry a fiftieth of a
// pixel. Which is said, and what there is is as good as that.
TEST(CalibrateSheets, SaysWhatAFewHexagonalLensesAreWorth) {
  const Taken taken = Photographs(kHexagonal, "-70,20,310;60,-40,290");
  const SolvedSheets solved = SolveSheets(taken.options, SilentProgress());
  ASSERT_EQ(solved.failures().size(), 1U);
  EXPECT_THAT(solved.failures()[0].lost,
              HasSubstr("layer 0: lenses at the panel's edge are known"));
  EXPECT_THAT(DescribeSheets(solved), HasSubstr("NOT certain"));
  EXPECT_THAT(SheetsPage(solved), HasSubstr("Not certain enough for a calibration"));
  const double sd = solved.sheets[0].report.drift_max_px;
  EXPECT_LT(sd, 0.06);
  EXPECT_LT(LargestRayDifference(taken, solved.calibration), 3 * sd);
}

// Exposed for a tenth of the time: an amplitude of 2.8 deviations of the noise, 9 dB. (Dark shots
// with more noise are not taken for dark.)
TEST(CalibrateSheets, FindsLensesWhoseSinusoidsAreFaint) {
  const Taken taken = Photographs(kSlanted, "-70,20,310;60,-40,290", true);
  const SolvedSheets solved = SolveSheets(taken.options, SilentProgress());
  ASSERT_EQ(solved.sheets.size(), 1U);
  const SolvedSheet& sheet = solved.sheets[0];
  EXPECT_TRUE(sheet.faint);
  EXPECT_THAT(DescribeSheets(solved), HasSubstr("by the finest sinusoid alone, since it is faint"));
  EXPECT_THAT(solved.failures(), IsEmpty());
  EXPECT_LT(LargestRayDifference(taken, solved.calibration), 0.04);
}

// A board of 7 x 5 squares beside the panel; what is traced is the sinusoids before two cameras and
// the board before these and six more.
class BesideBoard {
 public:
  BesideBoard() : folder_(ScratchFolder()) {
    WriteTextAtomically(folder_ / "sheet.toml", std::string(kDisplay) + kSlanted);
    const Display display = ReadDisplay(folder_ / "sheet.toml");
    truth_ = Built(display);
    SaveCalibration(folder_ / "truth.json", truth_);
    ShotList list =
        WithPrintedBoard(PlanShots(DesignCalibration(display), CalibrationMode::kPrecise));
    list.printed = PrintedBoard{{7 * 35 + 20, 5 * 35 + 20, 7, 5, 35, 10, 10, 900}, 11};
    WritePatterns(folder_ / "patterns", list, SilentProgress());
    WriteTextAtomically(folder_ / "patterns" / kPatternsDisplay, ToToml(display));
    WriteCameras();
    ShotList board = list, dark = list, sinusoids = list;
    board.shots = {list.shots.back()};
    dark.shots = {list.shots.front()};
    sinusoids.shots.pop_back();
    Photograph(sinusoids, "near.json", 1);
    Photograph(dark, "around.json", 1);
    Photograph(board, "near.json", 8);
    Photograph(board, "around.json", 8);
  }

  SolveSheetsOptions Options() const {
    SolveSheetsOptions options;
    options.patterns = folder_ / "patterns";
    options.photos = folder_ / "all";
    return options;
  }

  // The largest difference of what lines of sight meet in truth and by a solution in its own frame,
  // across the lenses.
  double LargestDifferencePx(const SolvedSheets& solved) const {
    const Rigid found_from_true = solved.board->display_from_board * Inverse(place_);
    const LayerSights truth(LayerOf(truth_)), found(LayerOf(solved.calibration));
    const double angle = LayerOf(truth_).lattice->rotation_rad;
    double most = 0;
    int compared = 0;
    for (const double x : {-70, 0, 70}) {
      for (int place = 0; place < 35; ++place) {
        const int column = place % 7 - 3, row = place / 7 - 2;
        const Vector3d eye(x, 10, 300), at(5.0 * column, 5.0 * row, 0);
        const auto is = truth.Seen(eye, at - eye);
        const auto said = found.Seen(found_from_true * eye, found_from_true.rotation * (at - eye));
        if (!is || !said) continue;
        const Vector2d off = said->emitter - is->emitter;
        const double across = off.x() * std::cos(angle) - off.y() * std::sin(angle);  // v down
        if (std::abs(across) > 2) continue;  // through the neighbouring lens
        ++compared;
        most = std::max(most, std::abs(across));
      }
    }
    EXPECT_GT(compared, 80);
    return most;
  }

 private:
  void WriteCameras() {
    TransformsJson near, around;
    const auto add = [](const Vector3d& eye, const Vector3d& target, TransformsJson& to, int n) {
      View view;
      view.name = fmt::format("camera_{:02}", n);
      view.image = view.name + ".png";
      view.camera.width = 540;
      view.camera.height = 270;
      view.camera.fx = view.camera.fy = 1250;
      view.camera.cx = 267;
      view.camera.cy = 138;
      view.camera_from_world = LookAt(eye, target, {0, 1, 0});
      to.views.push_back(view);
    };
    add({-60, 20, 310}, {39, 0, 0}, near, 1);
    add({90, -40, 310}, {39, 0, 0}, near, 2);
    const Vector3d board = place_.translation;
    int n = 3;
    for (const Vector2d& side : {Vector2d(-160, 0), Vector2d(160, 0), Vector2d(0, -160),
                                 Vector2d(0, 160), Vector2d(120, 120), Vector2d(-120, 120)}) {
      add(board + Vector3d(side.x(), side.y(), 260), board, around, n++);
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
    options.printed_board = "61,4,-2,1.5,-1,0.7";
    options.samples = samples;
    options.blur_px = samples > 1 ? 0.7 : 0;
    options.full_well_e = 20000;
    options.read_noise_e = 3;
    options.exposure = 0.27;
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
  Rigid place_ = PlaceOfPrintedBoard("61,4,-2,1.5,-1,0.7").value();
};

TEST(CalibrateSheets, FindsLensesByAPrintedBoardBesideThem) {
  const BesideBoard scene;
  const SolvedSheets solved = SolveSheets(scene.Options(), SilentProgress());
  const std::string text = DescribeSheets(solved);
  EXPECT_THAT(solved.board->cameras.failures, IsEmpty()) << text;
  EXPECT_THAT(solved.left_out, IsEmpty());
  ASSERT_EQ(solved.sheets.size(), 1U);
  EXPECT_EQ(solved.sheets[0].num_views, 2);
  EXPECT_THAT(text, HasSubstr("corners of the printed board in 8 photographs"));
  EXPECT_THAT(SheetsPage(solved), HasSubstr("(hollow: of the printed board alone)"));
  const auto is_of_board = [](const SolvedPhotos::Photo& photo) {
    return photo.file.find("printed_board") != std::string::npos;
  };
  EXPECT_EQ(std::count_if(solved.photos.begin(), solved.photos.end(), is_of_board), 8);
  const auto boards = std::find_if(solved.photos.begin(), solved.photos.end(), is_of_board);
  const double sd = solved.sheets[0].report.drift_max_px;
  EXPECT_LT(sd, 0.04);
  EXPECT_LT(scene.LargestDifferencePx(solved), 3 * sd);
  // The first panel stands in the display's middle.
  EXPECT_LT(LayerOf(solved.calibration).offset_mm.norm(), 0.2);
  // The board between sinusoids makes others of those after it.
  const fs::path photos = scene.Options().photos;
  fs::copy_file(photos / boards->file, photos / "camera_01_10_then_the_board.png");
  const SolvedSheets without = SolveSheets(scene.Options(), SilentProgress());
  EXPECT_EQ(without.sheets[0].num_views, 1);
  EXPECT_THAT(without.left_out,
              Contains(HasSubstr("position 1: camera_01_10_then_the_board.png shows the printed "
                                 "board between sinusoids")));
}

std::string Refusal(const SolveSheetsOptions& options) {
  try {
    SolveSheets(options, SilentProgress());
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CalibrateSheets, NeedPositionsWhoseCamerasAreKnown) {
  Taken taken = Photographs(kSlanted, "-70,20,310");
  const SolvedSheets one = SolveSheets(taken.options, SilentProgress());
  ASSERT_FALSE(one.failures().empty());
  EXPECT_THAT(one.failures()[0].lost, HasSubstr("there is one camera position only"));
  const Vector3d next = one.sheets[0].report.next_eye.value();
  EXPECT_THAT(SheetsPage(one), HasSubstr(fmt::format("gap, ({:.0f}, {:.0f}, {:.0f}) mm", next.x(),
                                                     next.y(), next.z())));
  TransformsJson cameras = ReadTransformsJson(taken.options.cameras);
  const fs::path other = taken.folder / "other.json";
  cameras.views.resize(1);
  cameras.views[0].camera.width = 99;
  WriteTransformsJson(other, cameras);
  taken.options.cameras = other;
  EXPECT_THAT(Refusal(taken.options), HasSubstr("has a camera of 99 x 160 px"));
  cameras.views[0].camera.width = 210;
  cameras.views[0].name = "elsewhere";
  cameras.views[0].image = "elsewhere.png";
  WriteTransformsJson(other, cameras);
  EXPECT_THAT(Refusal(taken.options), HasSubstr("has no frame of position 1 (eye_001_"));
  std::vector<fs::path> files;
  for (const auto& file : fs::directory_iterator(taken.options.photos))
    files.push_back(file.path());
  const auto third = *std::find_if(files.begin(), files.end(), [](const fs::path& file) {
    return file.filename().string().find("_u_0016_3") != std::string::npos;
  });
  // Taken once more on the spot, it would be taken for the next shot.
  const fs::path surplus = third.parent_path() / (third.stem().string() + "b.png");
  fs::copy_file(third, surplus);
  EXPECT_THAT(Refusal(taken.options), HasSubstr("no position has all shots"));
  fs::remove(surplus);
  fs::remove(third);
  EXPECT_THAT(Refusal(taken.options), HasSubstr("no position has all shots"));
}

}  // namespace
}  // namespace lamella
