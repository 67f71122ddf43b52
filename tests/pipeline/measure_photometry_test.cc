// A virtual display of unlike panels: its light photographed, measured, and its frames encoded by
// that, against the numbers that it was made of.
#include "pipeline/measure_photometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/color_difference.h"
#include "datasets_synthetic/cameras.h"
#include "distribute/panel_response.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/check_photos.h"
#include "pipeline/synth_photos.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr const char* kDisplay = R"(
name = "small"
viewing_distance_mm = 400
[panel]
width_px = 160
height_px = 120
pitch_mm = 0.5
[[layer]]
position_mm = -20
d0_mm = 4
[layer.barrier]
period_px = 5
aperture_px = 1
slots = 5
[[layer]]
position_mm = 20
d0_mm = 4
mirror_x = true
[layer.barrier]
period_px = 5
aperture_px = 1
slots = 5
)";

// A gamma and a twisted cell's S-shape, unlike in black, colour, brightness and fall-off.
Calibration TruthOf(Calibration truth) {
  LayerCalibration &back = truth.layers[0], &front = truth.layers[1];
  back.gain = 0.55;
  back.emitter.photometry.curve = {ToneCurve::Kind::kGamma, 2.35, {}};
  back.emitter.photometry.black = 8e-4;
  back.emitter.photometry.primaries << 0.9, 0.06, 0.01, 0.05, 0.95, 0.06, 0.01, 0.05, 0.8;
  back.emitter.photometry.falloff = 1.2;
  back.emitter.photometry.crosstalk = GaussianSpread(0.6);
  back.emitter.photometry.evenness = {2, 2, {1.06, 0.98, 1.0, 0.96}};
  back.modulator->photometry.curve = {ToneCurve::Kind::kGamma, 1.9, {}};
  back.modulator->photometry.black = 2.5e-3;
  front.gain = 0.42;
  ToneCurve cell{ToneCurve::Kind::kTable, 0, {}};
  for (int i = 0; i <= 255; ++i) {
    const double sine = std::sin(std::numbers::pi / 2 * std::pow(i / 255.0, 1.3));
    cell.table.push_back(sine * sine);
  }
  cell.table.back() = 1;
  front.emitter.photometry.curve = cell;
  front.emitter.photometry.black = 1.2e-3;
  front.emitter.photometry.primaries << 1, 0.08, 0, 0.03, 0.85, 0.05, 0.02, 0.04, 1;
  front.modulator->photometry.black = 1e-3;
  return truth;
}

// The list without every other level, of which a response needs 5, and lines of the back layer
// only.
void WriteShorterPatterns(const fs::path& folder, const Calibration& design) {
  ShotList list = PlanShots(design, CalibrationMode::kPhotometry);
  std::erase_if(list.shots, [](const PatternShot& shot) {
    if (shot.kind == PatternShot::Kind::kLines) return shot.panel.layer == 1;
    return shot.kind == PatternShot::Kind::kFlat && shot.pattern.color.r == shot.pattern.color.g &&
           (shot.pattern.color.g + 8) / 16 % 2 != 0;
  });
  WritePatterns(folder, list, SilentProgress());
}

// Four cameras; a panel's pixel has 1.45 of theirs.
void WriteCameras(const fs::path& file) {
  TransformsJson transforms;
  const Vector3d eyes[] = {{10, 5, 400}, {115, 30, 380}, {-90, 85, 380}, {40, -120, 390}};
  for (const Vector3d& eye : eyes) {
    View view;
    view.name = "view_" + std::to_string(transforms.views.size() + 1);
    view.image = file.parent_path() / (view.name + ".png");
    view.camera.width = 276;
    view.camera.height = 218;
    view.camera.fx = view.camera.fy = 1.45 / 0.5 * 400;
    view.camera.cx = 138;
    view.camera.cy = 109;
    view.camera_from_world = LookAt(eye, {0, 0, 0}, {0, 1, 0});
    transforms.views.push_back(view);
  }
  WriteTransformsJson(file, transforms);
}

SynthPhotosOptions CameraOf(const fs::path& folder) {
  SynthPhotosOptions options;
  options.misalignment = (folder / "true.json").string();
  options.shots = (folder / "light/shots.json").string();
  options.cameras = (folder / "cameras.json").string();
  options.samples = 16;  // with fewer, boards' corners are noisy and poses from them are off
  options.exposure = 1.4;
  options.full_well_e = 30000;
  options.read_noise_e = 4;
  options.pedestal = 0.03;
  options.vignetting = 0.25;
  options.blur_px = 0.7;
  options.curve = "linear";
  options.bits = 14;
  return options;
}

// The shutters are off by 2 % and more: the longer exposures are 1.02 and 0.975 of what they claim.
void MisstateShutters(const fs::path& file) {
  std::string shots = ReadText(file);
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"\"exposure\": 8", "8.16"},
                                 {"\"exposure\": 64", "62.4"}}) {
    for (auto at = shots.find(from); at != std::string::npos; at = shots.find(from, at + 1)) {
      shots.replace(at, from.size(), "\"exposure\": " + to);
    }
  }
  WriteTextAtomically(file, shots);
}

// In a folder: the display, its patterns, and photographs of what it is made of.
Calibration Photograph(const fs::path& folder) {
  WriteTextAtomically(folder / "small.toml", kDisplay);
  const Calibration design = DesignCalibration(ReadDisplay(folder / "small.toml"));
  Calibration truth = TruthOf(design);
  SaveCalibration(folder / "true.json", truth);
  SaveCalibration(folder / "geometry.json", design);
  WriteShorterPatterns(folder / "light", design);
  WriteCameras(folder / "cameras.json");
  MisstateShutters(folder / "light/shots.json");
  SynthPhotos(CameraOf(folder), folder / "lit", SilentProgress());
  return truth;
}

MeasurePhotometryOptions OptionsOf(const fs::path& folder) {
  MeasurePhotometryOptions options;
  options.patterns = folder / "light";
  options.photos = folder / "lit/images";
  options.calibration = folder / "geometry.json";
  return options;
}

double LightOf(const Photometry& photometry, double code) {
  return photometry.black + (1 - photometry.black) * LightOfCode(photometry.curve, code);
}

void ExpectResponse(const Photometry& measured, const Photometry& truth, double most) {
  EXPECT_NEAR(measured.black, truth.black, 5e-5);
  for (int code = 0; code <= 255; code += 5) {
    EXPECT_NEAR(LightOf(measured, code / 255.0), LightOf(truth, code / 255.0), most) << code;
  }
}

// What a layer truly shows of a scene's light at a place of its panel, encoded by a calibration.
Vector3d Shown(const Calibration& encoded_by, const Calibration& truth, int layer, const Rgb& light,
               double x, double y) {
  const Rgb8 codes = PanelResponse::Of(encoded_by, layer).Codes(light, x, y);
  const LayerCalibration& of = truth.layers[static_cast<std::size_t>(layer)];
  const Photometry& photometry = of.emitter.photometry;
  return of.gain * GainAt(photometry.evenness, x, y) * photometry.primaries *
         Vector3d(LightOf(photometry, codes.r / 255.0), LightOf(photometry, codes.g / 255.0),
                  LightOf(photometry, codes.b / 255.0));
}

// The mean difference of what the layers show of 5 x 5 x 5 colours that both can show, at places
// all over the panels, to eyes for which the back one's white is white.
double MeanDifference(const Calibration& encoded_by, const Calibration& truth) {
  const Vector3d white = Shown(encoded_by, truth, 0, {1, 1, 1}, 0.5, 0.5);
  double sum = 0;
  for (int i = 0; i < 125; ++i) {
    const auto level = [](int step) { return static_cast<float>(std::pow(step / 4.0, 2.2)); };
    const Rgb pure{level(i % 5), level(i / 5 % 5), level(i / 25)};
    const float grey = (pure.r + pure.g + pure.b) / 3;
    const Rgb light = Rgb{0.4F * grey, 0.4F * grey, 0.4F * grey} + 0.6F * pure;
    const double x = (i % 11 + 0.5) / 11, y = (i % 7 + 0.5) / 7;
    const Vector3d back = Shown(encoded_by, truth, 0, light, x, y).cwiseQuotient(white);
    const Vector3d front = Shown(encoded_by, truth, 1, light, x, y).cwiseQuotient(white);
    sum += ColorDifference(LabOf(back), LabOf(front));
  }
  return sum / 125;
}

void ExpectFound(const fs::path& folder, const Calibration& truth) {
  const MeasuredPhotometry measured = MeasurePhotometry(OptionsOf(folder), SilentProgress());
  SCOPED_TRACE(::testing::PrintToString(measured.lines));
  const std::vector<LayerCalibration>& layers = measured.calibration.layers;
  const Photometry& back = layers[0].emitter.photometry;
  EXPECT_EQ(back.curve.kind, ToneCurve::Kind::kGamma);
  EXPECT_NEAR(back.curve.gamma, 2.35, 0.01);
  EXPECT_NEAR(layers[0].modulator->photometry.curve.gamma, 1.9, 0.01);
  EXPECT_EQ(layers[1].emitter.photometry.curve.kind, ToneCurve::Kind::kTable);
  for (std::size_t l = 0; l < 2; ++l) {
    ExpectResponse(layers[l].emitter.photometry, truth.layers[l].emitter.photometry, 0.01);
    ExpectResponse(layers[l].modulator->photometry, truth.layers[l].modulator->photometry, 0.01);
    EXPECT_NEAR(layers[l].emitter.photometry.falloff, truth.layers[l].emitter.photometry.falloff,
                0.1);
  }
  EXPECT_NEAR(back.crosstalk.weights[back.crosstalk.weights.size() / 2],
              truth.layers[0].emitter.photometry.crosstalk.weights[12], 0.01);
  for (const double x : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(GainAt(back.evenness, x, 0.3),
                GainAt(truth.layers[0].emitter.photometry.evenness, x, 0.3), 0.01);
  }
  EXPECT_LT(MeanDifference(measured.calibration, truth), 0.5);
  EXPECT_GT(MeanDifference(DesignCalibration(ReadDisplay(folder / "small.toml")), truth), 5);
  EXPECT_EQ(measured.calibration.layers[0].gap_mm, truth.layers[0].gap_mm);
  const auto sd_of = [&](const std::string& name) {
    for (const ParameterDeviation& deviation : measured.deviations) {
      if (deviation.name == name) return deviation.sd;
    }
    ADD_FAILURE() << name;
    return 0.0;
  };
  // Poses from boards in so small photographs are off by degrees, which is an error of whole views.
  for (std::size_t l = 0; l < 2; ++l) {
    const double off =
        layers[l].emitter.photometry.falloff - truth.layers[l].emitter.photometry.falloff;
    EXPECT_LT(std::abs(off), 2.5 * sd_of("layer " + std::to_string(l) + " fall-off"));
  }
  EXPECT_LT(sd_of("layer 0 emitter gamma"), 0.01);
  SaveCalibration(folder / "measured.json", measured.calibration,
                  {{}, measured.deviations, measured.crosstalk});
  EXPECT_EQ(LoadCrosstalk(folder / "measured.json").size(), 1U);  // as many as have lines
  EXPECT_EQ(LoadLightDeviations(folder / "measured.json").size(), measured.deviations.size());
  EXPECT_EQ(LoadCalibration(folder / "measured.json").layers[1].emitter.photometry.curve,
            layers[1].emitter.photometry.curve);
}

// The line with which photographs are refused.
std::string Refusal(const MeasurePhotometryOptions& options) {
  try {
    MeasurePhotometry(options, SilentProgress());
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "accepted";
}

TEST(MeasurePhotometry, FindsWhatTheDisplayIsMadeOf) {
  const fs::path folder = ScratchFolder();
  const Calibration truth = Photograph(folder);
  ExpectFound(folder, truth);
  const MeasurePhotometryOptions options = OptionsOf(folder);
  // Numbers that are not linear, or shutters that are not what the list says.
  const std::string list = ReadText(folder / "light/patterns.json");
  std::string other = list;
  const std::string eight = "\"exposure\": 8";
  for (auto at = other.find(eight); at != std::string::npos; at = other.find(eight, at + 1)) {
    other.replace(at, eight.size(), "\"exposure\": 16");
  }
  WriteTextAtomically(folder / "light/patterns.json", other);
  EXPECT_THAT(Refusal(options),
              HasSubstr("layer 0 emitter: exposures of 1 : 16 come out as 1 : 8."));
  WriteTextAtomically(folder / "light/patterns.json", list);
  const fs::path second = folder / "lit/images/view_1_002_layer0_modulator_board.png";
  fs::rename(second, folder / "second.png");
  fs::copy_file(folder / "lit/images/view_1_003_layer0_emitter_board.png", second);
  EXPECT_THAT(Refusal(options),
              HasSubstr("does not show the board of layer 0 modulator, as shot 002_layer0"));
}

TEST(MeasurePhotometry, RefusesPhotographsThatDoNotServe) {
  const fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "small.toml", kDisplay);
  const Calibration design = DesignCalibration(ReadDisplay(folder / "small.toml"));
  SaveCalibration(folder / "geometry.json", design);
  WriteShorterPatterns(folder / "light", design);
  fs::create_directories(folder / "lit/images");
  const auto write = [&](std::size_t count, int bits) {
    const Image<Rgb> black(8, 8);
    for (std::size_t i = 0; i < count; ++i) {
      const auto name = std::to_string(1000 + i) + ".png";
      WriteNumbers(folder / "lit/images" / name, black.span(), bits);
    }
  };
  const std::size_t count = LoadShotList(folder / "light").shots.size();
  write(count + 3, 16);
  EXPECT_THAT(Refusal(OptionsOf(folder)),
              HasSubstr("photographs, not " + std::to_string(count) + " and 7 from every further"));
  write(count + 7, 16);
  EXPECT_THAT(Refusal(OptionsOf(folder)), HasSubstr("1001.png: does not show the board"));
  write(count + 7, 8);
  EXPECT_THAT(Refusal(OptionsOf(folder)), HasSubstr("1000.png: has 8 bits"));
  WritePatterns(folder / "light", PlanShots(design, CalibrationMode::kQuick), SilentProgress());
  EXPECT_THAT(Refusal(OptionsOf(folder)), HasSubstr("has no patterns of photometry"));
  WritePatterns(folder / "light", PlanShots(design, CalibrationMode::kPhotometry),
                SilentProgress());
  try {
    CheckPhotos(
        folder / "light", folder / "lit/images", [](const auto&, const auto&) {}, SilentProgress());
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_THAT(error.what(), HasSubstr("has patterns of photometry"));
  }
}

TEST(CalibrationPatterns, OfPhotometryReadBackAsTheyWereWritten) {
  const fs::path folder = ScratchFolder();
  WriteTextAtomically(folder / "small.toml", kDisplay);
  const ShotList list = PlanShots(DesignCalibration(ReadDisplay(folder / "small.toml")),
                                  CalibrationMode::kPhotometry);
  WritePatterns(folder, list, SilentProgress());
  const ShotList read = LoadShotList(folder);
  EXPECT_EQ(read.mode, CalibrationMode::kPhotometry);
  ASSERT_EQ(read.shots.size(), list.shots.size());
  for (std::size_t i = 0; i < read.shots.size(); ++i) {
    EXPECT_EQ(read.shots[i].name, list.shots[i].name);
    EXPECT_EQ(read.shots[i].kind, list.shots[i].kind);
    EXPECT_EQ(read.shots[i].panel, list.shots[i].panel);
    EXPECT_EQ(read.shots[i].pattern, list.shots[i].pattern);
    EXPECT_EQ(read.shots[i].exposure, list.shots[i].exposure);
    EXPECT_EQ(read.shots[i].first_position_only, list.shots[i].first_position_only);
  }
  EXPECT_EQ(ReadSrgb8(folder / "flat_160x120_303030.png")(80, 60), (Rgb8{48, 48, 48}));
  const Image<Rgb8> columns = ReadSrgb8(folder / "columns_160x120_8_4.png");
  EXPECT_EQ(columns(12, 7), (Rgb8{255, 255, 255}));
  EXPECT_EQ(columns(13, 7), Rgb8());
}

}  // namespace
}  // namespace lamella
