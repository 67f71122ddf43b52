// The crosstalk of a virtual display, photographed with a wide pupil and measured, against what
// eyes without one see of the same display along lines of sight.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "datasets_synthetic/cameras.h"
#include "datasets_synthetic/prototype.h"
#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/panel_rays.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/measure_photometry.h"
#include "pipeline/shown_frames.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// One layer; its gap follows.
constexpr const char* kOneLayer = R"(
name = "one layer"
viewing_distance_mm = 400
[panel]
width_px = 160
height_px = 120
pitch_mm = 0.5
[[layer]]
position_mm = 4
barrier = {period_px = 8, aperture_px = 2, slots = 4}
)";
constexpr double kEyeDistanceMm = 400, kPupilMm = 25;

// An emitter askew behind its modulator, whose light spreads, and panels that are never black.
Calibration SpreadingTruth(Calibration truth, double spread_px) {
  LayerCalibration& layer = truth.layers[0];
  layer.offset_mm = {0.13, -0.2};
  layer.rotation_rad = {0, 0, 0.006};
  layer.emitter.photometry.crosstalk = GaussianSpread(spread_px);
  layer.emitter.photometry.black = 1e-3;
  layer.modulator->photometry.black = 2e-3;
  return truth;
}

// Levels only as many as a response needs, at one exposure.
void WriteLinePatterns(const fs::path& folder, const Calibration& design) {
  ShotList list = PlanShots(design, CalibrationMode::kPhotometry);
  std::erase_if(list.shots, [](const PatternShot& shot) {
    const Rgb8& color = shot.pattern.color;
    return shot.exposure != 1 || (shot.kind == PatternShot::Kind::kFlat && color.r == color.g &&
                                  color.g == color.b && (color.g + 1) % 64 > 1);
  });
  WritePatterns(folder, list, SilentProgress());
}

void WriteEyes(const fs::path& file) {
  TransformsJson transforms;
  const Vector3d eyes[] = {
      {10, 5, kEyeDistanceMm}, {115, 30, 380}, {-90, 85, 380}, {40, -120, 390}};
  for (const Vector3d& eye : eyes) {
    View view;
    view.name = "view_" + std::to_string(transforms.views.size() + 1);
    view.image = file.parent_path() / (view.name + ".png");
    view.camera.width = 276;
    view.camera.height = 218;
    view.camera.fx = view.camera.fy = 1.45 / 0.5 * kEyeDistanceMm;
    view.camera.cx = 138;
    view.camera.cy = 109;
    view.camera_from_world = LookAt(eye, {0, 0, 0}, {0, 1, 0});
    transforms.views.push_back(view);
  }
  WriteTransformsJson(file, transforms);
}

Calibration PhotographLines(const fs::path& folder, const std::string& gap, double spread_px) {
  WriteTextAtomically(folder / "display.toml", kOneLayer + gap);
  const Calibration design = DesignCalibration(ReadDisplay(folder / "display.toml"));
  Calibration truth = SpreadingTruth(design, spread_px);
  SaveCalibration(folder / "true.json", truth);
  Calibration geometry = truth;
  geometry.layers[0].emitter.photometry = design.layers[0].emitter.photometry;
  geometry.layers[0].modulator->photometry = design.layers[0].modulator->photometry;
  SaveCalibration(folder / "geometry.json", geometry);
  WriteLinePatterns(folder / "light", design);
  WriteEyes(folder / "cameras.json");
  SynthPhotosOptions options;
  options.misalignment = (folder / "true.json").string();
  options.shots = (folder / "light/shots.json").string();
  options.cameras = (folder / "cameras.json").string();
  options.samples = 64;
  options.aperture_mm = kPupilMm;
  options.focus_mm = kEyeDistanceMm;
  // Of 30000, one photograph's, the matrix is within 0.004 at any number of lines, but the kernel's
  // middle weight up to 0.0056 off.
  options.full_well_e = 60000;
  options.read_noise_e = 4;
  options.pedestal = 0.03;
  options.curve = "linear";
  options.bits = 14;
  SynthPhotos(options, folder / "lit", SilentProgress());
  return truth;
}

// In the display's frame, the eye that looks through the middle of a modulator's column at that of
// an emitter's, both half-way down their panels.
Vector3d EyeBefore(const LayerCalibration& layer, double opening_u, double emitter_u) {
  const double v = layer.emitter.height_px / 2.0;
  const Vector3d opening = PanelPoint(*layer.modulator, {opening_u, v});
  const Vector3d emitter = StackFromEmitter(layer) * PanelPoint(layer.emitter, {emitter_u, v});
  const Vector3d in_air = layer.index * (opening - emitter).normalized();  // x and y, by Snell
  const double z = std::sqrt(1 - in_air.head<2>().squaredNorm());
  return layer.display_from_stack *
         (opening + kEyeDistanceMm * Vector3d(in_air.x() / z, in_air.y() / z, 1));
}

// Light of an opening's column, on average over its width.
double LightThrough(const Prototype& prototype, const LayerCalibration& layer, const Vector3d& eye,
                    int column) {
  constexpr int kSights = 1000;
  double light = 0;
  for (int i = 0; i < kSights; ++i) {
    const Vector3d place =
        layer.display_from_stack * PanelPoint(*layer.modulator, {column + (i + 0.5) / kSights,
                                                                 layer.modulator->height_px / 2.0});
    light += static_cast<double>(LightAlong(prototype, eye, place - eye).g) / kSights;
  }
  return light;
}

// The share of each view in what pinhole eyes see, of the shots that were photographed.
MatrixXd TrueCrosstalk(const fs::path& folder, const Calibration& truth) {
  constexpr int K = kLinesPeriodPx, kColumn = 80;
  const LayerCalibration& layer = truth.layers[0];
  const std::string lines = "_lines_";
  MatrixXd views(K, K);
  int found = 0;
  for (const Shot& shot : ReadShots(folder / "light/shots.json")) {
    const auto at = shot.name.find(lines);
    if (at == std::string::npos) continue;
    const int k = std::stoi(shot.name.substr(at + lines.size()));
    const Prototype prototype{truth, ShotLoader(truth).Load(shot)};
    for (int j = 0; j < K; ++j) {
      const Vector3d eye = EyeBefore(layer, kColumn + kOpeningPx + 0.5, kColumn + j + 0.5);
      views(j, k) = LightThrough(prototype, layer, eye, kColumn + kOpeningPx);
    }
    ++found;
  }
  EXPECT_EQ(found, K);
  const double black = layer.emitter.photometry.black * layer.gain;
  for (int j = 0; j < K; ++j) {
    views.row(j) = (views.row(j).array() - black) / (views.row(j).sum() - K * black);
  }
  return views;
}

// Which frames and pictures are made by, likewise to 0.005, and as well as it is said to be known.
void ExpectTrueSpread(const MeasuredPhotometry& found, const Calibration& truth) {
  const Calibration& measured = found.calibration;
  const auto middle = [](const Calibration& calibration) {
    const SpreadKernel& kernel = calibration.layers[0].emitter.photometry.crosstalk;
    return kernel.weights[kernel.weights.size() / 2];
  };
  EXPECT_NEAR(middle(measured), middle(truth), 0.005);
  for (const ParameterDeviation& deviation : found.deviations) {
    if (deviation.name != "layer 0 emitter own light") continue;
    EXPECT_NEAR(middle(measured), middle(truth), 3 * deviation.sd);
    EXPECT_LT(deviation.sd, 0.02);
    fmt::print("own light off by {:.4f}, sd {:.4f}\n", middle(measured) - middle(truth),
               deviation.sd);
    return;
  }
  ADD_FAILURE() << "no deviation";
}

void ExpectTrueCrosstalk(const std::string& gap, double spread_px) {
  const fs::path folder = ScratchFolder();
  const Calibration truth = PhotographLines(folder, gap, spread_px);
  MeasurePhotometryOptions options;
  options.patterns = folder / "light";
  options.photos = folder / "lit/images";
  options.calibration = folder / "geometry.json";
  options.pupil_mm = kPupilMm;
  const MeasuredPhotometry measured = MeasurePhotometry(options, SilentProgress());
  SCOPED_TRACE(::testing::PrintToString(measured.lines));
  ASSERT_EQ(measured.crosstalk.size(), 1U);
  const MeasuredCrosstalk& crosstalk = measured.crosstalk[0];
  const MatrixXd seen = TrueCrosstalk(folder, truth);
  EXPECT_LT((crosstalk.without_pupil - seen).cwiseAbs().maxCoeff(), 0.005);
  EXPECT_GT((crosstalk.with_pupil - seen).cwiseAbs().maxCoeff(), 0.02);
  ExpectTrueSpread(measured, truth);
  // With the pupil left in, it passes for a wider spread.
  options.pupil_mm = 0;
  const MeasuredPhotometry blurred = MeasurePhotometry(options, SilentProgress());
  ASSERT_EQ(blurred.crosstalk.size(), 1U);
  EXPECT_GT((blurred.crosstalk[0].without_pupil - seen).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_EQ(blurred.crosstalk[0].without_pupil, blurred.crosstalk[0].with_pupil);
}

TEST(MeasurePhotometry, FindsCrosstalkWithoutTheCamerasPupil) {
  ExpectTrueCrosstalk("d0_mm = 8", 0.6);
}

TEST(MeasurePhotometry, FindsCrosstalkThroughGlassInAMirror) {
  ExpectTrueCrosstalk("gap_mm = 12\nindex = 1.5\nmirror_x = true", 0.4);
}

}  // namespace
}  // namespace lamella
