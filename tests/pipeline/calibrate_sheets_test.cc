// Sinusoids on a virtual prototype with a lens sheet that is not the designed one, photographed and
// solved: against the prototype's own numbers, its lines of sight and the visual.json of them.
#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/calibrated_sheet.h"
#include "lightfield/error.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/solve_sheets.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
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
