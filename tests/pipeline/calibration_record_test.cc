#include "pipeline/calibration_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

// Every field away from its default, and numbers without short decimals.
Calibration Everything() {
  Calibration calibration = DesignCalibration(FindDisplay("paper-two-layer"));
  LayerCalibration& layer = calibration.layers[0];
  layer.display_from_stack.rotation = Eigen::Quaterniond(0.9, 0.1, 0.2, -0.3).normalized();
  layer.display_from_stack.translation = {1.0 / 3, -2.0 / 7, 1e-17};
  layer.offset_mm = {0.1, -1.0 / 3};
  layer.rotation_rad = {0.001, 1.0 / 300, -0.02};
  layer.gap_mm = 7.45;
  layer.index = 1.49;
  layer.gain = 0.1 + 0.2;
  layer.plate = Plate{3, 1.52, Eigen::Vector3d(1, 2, 3).normalized()};
  PanelCalibration& panel = layer.emitter;
  panel.scale = 1.0 / 3000;
  panel.aspect = -1e-5;
  panel.skew = 2e-5;
  panel.bow_mm = 0.3;
  panel.pincushion = 0.01;
  panel.mirror_x = true;
  panel.rgb_stripes = true;
  panel.photometry.curve = {ToneCurve::Kind::kTable, 2.2, {0, 1.0 / 3, 1}};
  panel.photometry.black = 1e-4;
  panel.photometry.primaries << 0.9, 0.1, 0, 0.05, 0.9, 0.1, 0, 0.03, 1.0 / 3;
  panel.photometry.falloff = 0.7;
  panel.photometry.crosstalk = GaussianSpread(0.6);
  panel.photometry.evenness = {2, 1, {1.1, 0.9}};
  layer.modulator->photometry.curve = {ToneCurve::Kind::kGamma, 1.8, {}};
  LayerCalibration& lenses = calibration.layers[1];
  lenses.modulator.reset();
  lenses.lattice = LensLattice{LensLattice::Type::kHexagonal, 2.33, 0.5236, {0.1, 0.9}, 3};
  return calibration;
}

TEST(CalibrationRecord, ReadsBackEveryBit) {
  const auto file = ScratchFolder() / "calibration.json";
  const Calibration calibration = Everything();
  SaveCalibration(file, calibration);
  const Calibration again = LoadCalibration(file);
  EXPECT_EQ(CalibrationText(again), CalibrationText(calibration));
  const LayerCalibration &a = again.layers[0], &b = calibration.layers[0];
  EXPECT_EQ(a.display_from_stack.rotation.coeffs(), b.display_from_stack.rotation.coeffs());
  EXPECT_EQ(a.display_from_stack.translation, b.display_from_stack.translation);
  EXPECT_EQ(a.rotation_rad, b.rotation_rad);
  EXPECT_EQ(a.offset_mm, b.offset_mm);
  EXPECT_EQ(a.gain, b.gain);
  EXPECT_EQ(a.emitter.photometry.primaries, b.emitter.photometry.primaries);
  EXPECT_EQ(a.emitter.photometry.curve, b.emitter.photometry.curve);
  EXPECT_EQ(a.emitter.photometry.crosstalk, b.emitter.photometry.crosstalk);
  EXPECT_EQ(a.emitter.photometry.evenness, b.emitter.photometry.evenness);
  EXPECT_EQ(a.modulator->photometry.curve, b.modulator->photometry.curve);
  EXPECT_EQ(a.emitter.bow_mm, b.emitter.bow_mm);
  EXPECT_TRUE(a.emitter.mirror_x && a.emitter.rgb_stripes);
  EXPECT_EQ(a.plate->normal, b.plate->normal);
  EXPECT_FALSE(again.layers[1].modulator);
  EXPECT_EQ(again.layers[1].lattice->type, LensLattice::Type::kHexagonal);
  EXPECT_EQ(again.layers[1].lattice->phase, Eigen::Vector2d(0.1, 0.9));
}

CalibrationMeasurement Measured() {
  CalibrationMeasurement m;
  m.program = "lamella 9";
  m.solver = "a solver";
  m.reference = {1, PanelId::kModulator};
  m.eye_box = {80, 60, 480, 720};
  m.ray_rms_sd_px = 1.0 / 300;
  m.ray_max_sd_px = 1.0 / 70;
  m.worst = {{0, PanelId::kEmitter}, {3.5, 1.0 / 3}, {-80, 60, 480}};
  m.chi2 = 1.0 / 0.97;
  m.slip_px = 0.0123;
  m.deviations = {{"layer 1 gap", "mm", 1.0 / 700}, {"layer 1 tilt x", "rad", 1e-5}};
  m.groups = {{"bow", true, "chi^2 falls"}, {"index", false, "the photographs do not ask"}};
  m.photos = {{"a \"b\".png", "0123"}};
  return m;
}

std::vector<ParameterDeviation> Light() { return {{"layer 0 fall-off", "", 1.0 / 30}}; }

// Not symmetric, so that rows are not taken for columns.
std::vector<MeasuredCrosstalk> Crosstalk() {
  Eigen::MatrixXd without(3, 3), with(3, 3);
  without << 0.7, 0.2, 0.1, 0, 1, 0, 1.0 / 3, 1.0 / 3, 1 - 2.0 / 3;
  with << 0.5, 0.25, 0.25, 0.25, 0.5, 0.25, 0.125, 0, 0.875;
  return {{1, 2.0 / 3, without, with}};
}

TEST(CalibrationRecord, SaysHowItWasMeasured) {
  const auto file = ScratchFolder() / "calibration.json";
  SaveCalibration(file, Everything(), {Measured(), Light()});
  EXPECT_EQ(CalibrationText(LoadCalibration(file)), CalibrationText(Everything()));
  const auto again = LoadMeasurement(file);
  ASSERT_TRUE(again);
  EXPECT_EQ(MeasurementText(*again), MeasurementText(Measured()));
  EXPECT_EQ(again->reference, Measured().reference);
  EXPECT_EQ(again->ray_rms_sd_px, 1.0 / 300);
  EXPECT_EQ(again->worst.eye_mm, Measured().worst.eye_mm);
  EXPECT_EQ(again->deviations[0].sd, 1.0 / 700);
  EXPECT_TRUE(again->groups[0].freed);
  ASSERT_EQ(LoadLightDeviations(file).size(), 1U);
  EXPECT_EQ(LoadLightDeviations(file)[0].sd, 1.0 / 30);
  EXPECT_EQ(again->photos[0].file, "a \"b\".png");
  SaveCalibration(file, Everything());
  EXPECT_FALSE(LoadMeasurement(file));
}

TEST(CalibrationRecord, KeepsTheCrosstalkOfViews) {
  const auto file = ScratchFolder() / "calibration.json";
  SaveCalibration(file, Everything(), {{}, {}, Crosstalk()});
  EXPECT_EQ(CalibrationText(LoadCalibration(file)), CalibrationText(Everything()));
  const std::vector<MeasuredCrosstalk> again = LoadCrosstalk(file);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].layer, 1);
  EXPECT_EQ(again[0].pupil_px, 2.0 / 3);
  EXPECT_EQ(again[0].without_pupil, Crosstalk()[0].without_pupil);
  EXPECT_EQ(again[0].with_pupil, Crosstalk()[0].with_pupil);
  SaveCalibration(file, Everything());
  EXPECT_TRUE(LoadCrosstalk(file).empty());
}

TEST(CalibrationRecord, TakesWhatIsLeftOutAsDesigned) {
  const auto file = ScratchFolder() / "calibration.json";
  WriteTextAtomically(file, R"({"format_version": 1, "display": "one", "layers": [
    {"display_from_reference": {}, "emitter": {"width_px": 8, "height_px": 6, "pitch_mm": 0.3}}]})");
  const Calibration calibration = LoadCalibration(file);
  ASSERT_EQ(calibration.layers.size(), 1U);
  EXPECT_FALSE(calibration.layers[0].modulator);
  EXPECT_EQ(calibration.layers[0].index, 1);
  EXPECT_EQ(calibration.layers[0].gain, 1);
  EXPECT_EQ(calibration.layers[0].emitter.photometry.curve, ToneCurve());
}

TEST(CalibrationRecord, RefusesWithOneLine) {
  const auto file = ScratchFolder() / "calibration.json";
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string text = CalibrationText(Everything(), {Measured(), Light(), Crosstalk()});
    const std::size_t at = text.find(from);
    if (at == std::string::npos) return "no " + from;
    WriteTextAtomically(file, text.replace(at, from.size(), to));
    try {
      LoadCalibration(file);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("\"format_version\": 1", "\"format_version\": 2"), HasSubstr("newer"));
  EXPECT_THAT(refusal("\"bow_mm\"", "\"bowmm\""), HasSubstr("did you mean \"bow_mm\""));
  EXPECT_THAT(refusal("\"gap_mm\": 7.45", "\"gap_mm\": -7"), HasSubstr("layer 0: gap_mm = -7"));
  EXPECT_THAT(refusal("\"gap_mm\": 7.45", "\"gap_mm\": \"x\""), HasSubstr("layers[0]: \"gap_mm\""));
  EXPECT_THAT(refusal("\"mirror_x\": true", "\"mirror_x\": 1"), HasSubstr("true or false"));
  EXPECT_THAT(refusal("\"hexagonal\"", "\"hex\""), HasSubstr("line, square or hexagonal"));
  EXPECT_THAT(refusal("\"display_from_reference\"", "\"display_from_stack\""),
              HasSubstr("which is display_from_reference now; rename it"));
  EXPECT_THAT(refusal("\"chi2\"", "\"chi\""), HasSubstr("measured: there is no key \"chi\""));
  EXPECT_THAT(refusal("\"rms_sd_px\": ", "\"rms_sd_px\": -"), HasSubstr("0 or more"));
  EXPECT_THAT(refusal("\"freed\": true", "\"freed\": 1"), HasSubstr("true or false"));
  EXPECT_THAT(refusal("\"views\": 3", "\"views\": 4"),
              HasSubstr("measured_crosstalk[0]: \"without_pupil\" is not 16 finite numbers"));
  EXPECT_THAT(refusal("0.875", "[0.875, 0]"), HasSubstr("\"with_pupil\" is not 9 finite"));
  EXPECT_THAT(refusal("0.875", "\"x\""), HasSubstr("\"with_pupil\" is not 9 finite"));
  EXPECT_THAT(refusal("0.875", "0.87"), HasSubstr("rows of shares whose sum is 1"));
  EXPECT_THAT(refusal("0.875", "-0.875"), HasSubstr("rows of shares whose sum is 1"));
  EXPECT_THAT(refusal("\"pupil_px\": ", "\"pupil_px\": -"), HasSubstr("0 or more"));
  EXPECT_THAT(refusal("\"pupil_px\"", "\"pupil\""), HasSubstr("did you mean \"pupil_px\""));
  EXPECT_THAT(refusal("{", "["), HasSubstr("is no JSON"));
}

}  // namespace
}  // namespace lamella
