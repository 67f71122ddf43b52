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

#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using ::testing::HasSubstr;

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
    layer.gap_mm *= larger * larger;
    layer.lattice->pitch_mm *= larger;
    layer.lattice->focal_mm *= larger * larger;
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
}

}  // namespace
}  // namespace lamella
