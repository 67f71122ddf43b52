// What visual.json's published formula says of a calibrated sheet's sub-pixels, against where their
// light goes.
#include "lightfield/calibrated_sheet.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

Display Sheet(double slant) {
  Display display;
  display.name = "sheet";
  display.width_px = 240;
  display.height_px = 160;
  display.pitch_mm = 0.2;
  display.viewing_distance_mm = 400;
  display.layers.resize(1);
  display.layers[0].d0_mm = 1.1;
  display.layers[0].optics = Lenticular{4.7, slant, 9, 0.3, 0};
  return display;
}

TEST(SheetFor, RoundTripsThroughThePublishedFormula) {
  for (const double slant : {1.0 / 6, -0.25}) {
    const Display display = Sheet(slant);
    Calibration calibration = DesignCalibration(display);
    LayerCalibration& layer = calibration.layers[0];
    layer.lattice->pitch_mm *= 1.003;
    layer.lattice->rotation_rad += 0.002;
    layer.lattice->phase.x() = 0.37;
    layer.offset_mm = {0.04, -0.11};
    layer.rotation_rad.z() = -0.003;
    layer.emitter.scale = 0.002;
    const SheetForViewer sheet = SheetFor(layer, 400, "sheet");
    const CalibratedMap map(display, calibration, 0);
    const double th = layer.lattice->rotation_rad;
    const double pitch = layer.lattice->pitch_mm * (1 + layer.gap_mm / 400);
    int compared = 0;
    for (int i = 0; i < 240 * 160 * 3; i += 17) {
      const int channel = i % 3, column = i / 3 % 240, row = i / 3 / 240;
      const auto beam = map.BeamOf(0, channel, column, row);
      ASSERT_TRUE(beam);
      const double x = beam->beam.x.At(400), y = beam->beam.y.At(400);
      const double viewer = x * std::cos(th) + y * std::sin(th);
      const double expected = 0.5 + viewer * layer.gap_mm / (400 * pitch);
      const double view = LookingGlassView(sheet.panel, column, row, channel);
      const double difference = view - expected;
      EXPECT_NEAR(difference, std::round(difference), 1e-3) << column << " " << row;
      ++compared;
    }
    EXPECT_GT(compared, 6000);
    EXPECT_NEAR(std::tan(sheet.view_cone_deg / 2 * M_PI / 180), pitch / 2 / layer.gap_mm, 1e-9);
  }
}

TEST(SheetFor, RefusesWhatVisualJsonCannotSay) {
  const auto refuses = [](const LayerCalibration& layer) {
    EXPECT_THROW(SheetFor(layer, 400, "calibration.json"), Error);
  };
  LayerCalibration layer = DesignCalibration(Sheet(1.0 / 6)).layers[0];
  layer.emitter.mirror_x = true;
  refuses(layer);
  refuses(DesignCalibration(Sheet(0)).layers[0]);
  Display other = Sheet(0.2);
  other.layers[0].optics = Barrier{};
  refuses(DesignCalibration(other).layers[0]);
}

}  // namespace
}  // namespace lamella
