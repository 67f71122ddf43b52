// A simulated eye and a virtual photograph are two ways to one picture: the ray map integrated per
// axis, and lines of sight traced from a calibration's poses through the frames' final codes.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "distribute/simulate_eye.h"
#include "lightfield/calibration.h"
#include "pipeline/calibrated_eyes.h"
#include "tests/pipeline/prototype_view.h"

namespace lamella {
namespace {

// paper-two-layer with an eighth of its panel's width: the back layer seen in a mirror.
Display EyePrototype() {
  Display display;
  display.name = "small";
  display.width_px = 240;
  display.height_px = 162;
  display.pitch_mm = 0.3113158871666749;
  display.viewing_distance_mm = 600;
  display.layers.resize(2);
  display.layers[0].position_mm = -10;
  display.layers[0].mirror_x = true;
  display.layers[1].position_mm = 10;
  return display;
}

// Smooth light over the emitters, another one in every slot, layer and colour.
Rgb LightOf(std::size_t layer, int slot, int x, int y) {
  const auto wave = [&](int channel) {
    const double seed = static_cast<double>(layer) * 31 + slot * 7 + channel * 3;
    const double a = 0.05 + 0.4 * std::fmod(seed * 0.618034, 1), b = 0.45 - a;
    return static_cast<float>(0.5 + 0.25 * std::sin(a * x + b * y + seed) +
                              0.25 * std::cos(b * x - a * y + 2 * seed));
  };
  return {wave(0), wave(1), wave(2)};
}

LayerImages Emitters(const Display& display) {
  LayerImages layers;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    layers.slots.emplace_back();
    for (int slot = 0; slot < 9; ++slot) {
      EmitterImage image{Image<Rgb>(display.width_px, display.height_px),
                         Image<float>(display.width_px, display.height_px, 1.0F)};
      for (int y = 0; y < display.height_px; ++y) {
        for (int x = 0; x < display.width_px; ++x) image.color(x, y) = LightOf(l, slot, x, y);
      }
      layers.slots.back().push_back(std::move(image));
    }
  }
  return layers;
}

// Of linear light, peak 1; the photograph times `gain`.
double PsnrDb(const Image<Rgb>& eye, const Image<Rgb>& photograph, double gain) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Rgb &a = eye.data()[i], &b = photograph.data()[i];
    for (const auto& [p, q] : {std::pair(a.r, b.r), std::pair(a.g, b.g), std::pair(a.b, b.b)}) {
      sum += std::pow(static_cast<double>(p) - gain * static_cast<double>(q), 2);
      ++count;
    }
  }
  return 10 * std::log10(count / sum);
}

// Panels that leak, and are slower than their slots.
void MakeReal(Display& display) {
  display.contrast = 50;
  display.slot_crosstalk = 0.2;
  std::get<Barrier>(display.layers[0].optics).contrast = 30;
  std::get<Barrier>(display.layers[1].optics).contrast = 60;
}

class PrototypeAndEye : public testing::TestWithParam<bool> {};

TEST_P(PrototypeAndEye, SeeTheSamePictureFromTheViewingPosition) {
  Display display = EyePrototype();
  if (GetParam()) MakeReal(display);
  const LayerImages layers = Emitters(display);
  Prototype prototype = Showing(display, DesignCalibration(display), layers);
  for (ShownLayer& shown : prototype.shown) {
    if (GetParam()) shown = WithSlotCrosstalk(shown, SlotOrder(3), display.slot_crosstalk);
  }
  for (const double x : {0.0, 24.5}) {
    Eye eye;
    eye.position = {x, -x / 2, 600};
    eye.pixel_mm = 2 * display.pitch_mm;
    eye.width = 110;
    eye.height = 71;
    eye.left_mm = -eye.width * eye.pixel_mm / 2 + 0.1;
    eye.top_mm = eye.height * eye.pixel_mm / 2 - 0.05;
    const Image<Rgb> photograph =
        PhotographPrototype(prototype, CameraOf(eye), 256, SilentProgress());
    // An eye's picture is divided by the brightness (a/P)^2/n, a photograph is not.
    const double brightness = Brightness(display, display.layers[0]);
    EXPECT_NEAR(brightness, 1.0 / 18, 1e-12);
    const auto agreement = [&](const Eye& other) {
      return PsnrDb(SimulateEye(layers, display, other).color, photograph, 1 / brightness);
    };
    RecordProperty("psnr_linear_db_at_" + std::to_string(static_cast<int>(x)),
                   std::to_string(agreement(eye)));
    // Neighbouring slots of these emitters have nothing in common, which is as hard as it can be.
    EXPECT_GT(agreement(eye), 46) << x;
    // And the figure can see a difference: a pixel aside they are two pictures.
    Eye beside = eye;
    beside.left_mm += eye.pixel_mm;
    EXPECT_LT(agreement(beside), 25);
  }
}

INSTANTIATE_TEST_SUITE_P(Panels, PrototypeAndEye, testing::Bool(),
                         [](const auto& test) { return test.param ? "AsTheyAre" : "Ideal"; });

// The preview's eyes before a calibrated display, where the calibration says that it is as
// designed; with emitters of which nothing is known.
TEST(CalibratedEyes, SeeWhatSimulatedEyesSeeOfADisplayAsDesigned) {
  LayersRecord record;
  record.display = EyePrototype();
  std::get<Barrier>(record.display.layers[0].optics).contrast = 30;
  record.display.slot_crosstalk = 0.2;
  record.calibration = DesignCalibration(record.display);
  // Light that two panels share unequally is made up for.
  record.calibration->layers[0].gain = 0.7;
  LayerImages layers = Emitters(record.display);
  for (EmitterImage& slot : layers.slots[1]) {
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < record.display.width_px; ++x) {
        slot.color(x, y) = {};
        slot.coverage(x, y) = 0;
      }
    }
  }
  Eye eye;
  eye.position = {12, -7, 600};
  eye.pixel_mm = 4 * record.display.pitch_mm;
  eye.width = 50;
  eye.height = 34;
  eye.left_mm = -eye.width * eye.pixel_mm / 2;
  eye.top_mm = eye.height * eye.pixel_mm / 2;
  const EyePicture expected = SimulateEye(layers, record.display, eye);
  const EyePicture seen = CalibratedEyes(record, layers).See(eye, {}, 256);
  EXPECT_GT(PsnrDb(expected.color, seen.color, 1), 40);
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      EXPECT_NEAR(seen.coverage(x, y), expected.coverage(x, y), 0.15) << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace lamella
