// Sinusoids on a virtual prototype with a lens sheet that is not the designed one, photographed and
// solved: against the prototype's own numbers, its lines of sight and the visual.json of them.
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_sheet.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/solve_sheets.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

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

// The sheet as it was made: half a percent wide, a quarter of a degree askew, shifted, and the
// panel behind it not where it was to be.
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
  return built;
}

struct Taken {
  fs::path folder;
  Calibration truth;
  SolveSheetsOptions options;
};

Taken Photographs(const char* optics, const std::string& eyes) {
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
  options.read_noise_e = 3;
  options.exposure = 0.27;
  options.bits = 12;
  SynthPhotos(options, folder / "taken", SilentProgress());
  taken.options.patterns = folder / "patterns";
  taken.options.photos = folder / "taken/images";
  taken.options.cameras = folder / "taken/transforms.json";
  taken.options.camera_sd_mm = 0.1;
  return taken;
}

TEST(CalibrateSheets, FindTheSheetOfAVirtualPrototype) {
  for (const char* optics : {kSlanted, kHexagonal}) {
    const Taken taken = Photographs(optics, "-70,20,310;60,-40,290");
    const SolvedSheets solved = SolveSheets(taken.options, SilentProgress());
    fmt::print("{}", DescribeSheets(solved));
    const LayerCalibration& truth = taken.truth.layers[0];
    const LayerCalibration& found = solved.calibration.layers[0];
    fmt::print("pitch {} {} rotation {} {} phase {} {} {} {} gap {} {}\n", truth.lattice->pitch_mm,
               found.lattice->pitch_mm, truth.lattice->rotation_rad, found.lattice->rotation_rad,
               truth.lattice->phase.x(), found.lattice->phase.x(), truth.lattice->phase.y(),
               found.lattice->phase.y(), truth.gap_mm, found.gap_mm);
  }
}

}  // namespace
}  // namespace lamella
