// Misaligned displays against the bounds that were asked for.
#include "datasets_synthetic/misalign.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Calibration Design() {
  LayerCalibration layer;
  layer.emitter.width_px = 1920;
  layer.emitter.height_px = 1080;
  layer.emitter.pitch_mm = 0.3;
  layer.gap_mm = 6;
  layer.index = 1.49;
  Calibration design{"two", {layer, layer}};
  design.layers[0].emitter.mirror_x = true;
  design.layers[0].display_from_stack.translation.z() = -40;
  for (LayerCalibration& each : design.layers) each.modulator = each.emitter;
  return design;
}

Misalignment Most() {
  Misalignment by;
  by.least_gap_mm = 3;
  by.most_gap_mm = 10;
  return by;
}

TEST(Misaligned, StaysWithinWhatIsAskedFor) {
  double widest_turn = 0, widest_shift = 0;
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    const Calibration design = Design(), built = Misaligned(design, Most(), seed);
    for (std::size_t i = 0; i < 2; ++i) {
      const LayerCalibration& layer = built.layers[i];
      EXPECT_GE(layer.gap_mm, 3);
      EXPECT_LE(layer.gap_mm, 10);
      EXPECT_LE(layer.offset_mm.cwiseAbs().maxCoeff(), 20);
      EXPECT_LE(std::abs(layer.rotation_rad.z()), 5 * kDegree);
      EXPECT_LE(std::abs(layer.emitter.scale), 0.005);
      widest_turn = std::max(widest_turn, std::abs(layer.rotation_rad.z()));
      widest_shift = std::max(widest_shift, layer.offset_mm.cwiseAbs().maxCoeff());
      for (const double u : {0, 1920}) {  // no corner before the modulator
        for (const double v : {0, 1080}) {
          EXPECT_LT((StackFromEmitter(layer) * PanelPoint(layer.emitter, {u, v})).z(), 0);
        }
      }
    }
    const Eigen::Vector3d shift = built.layers[0].display_from_stack.translation -
                                  design.layers[0].display_from_stack.translation;
    EXPECT_LE(shift.cwiseAbs().maxCoeff(), 20);
    EXPECT_LE(std::abs(built.layers[0].modulator->scale), 0.005);
  }
  EXPECT_GT(widest_turn, 4.5 * kDegree);
  EXPECT_GT(widest_shift, 18);
}

TEST(Misaligned, KeepsTheFirstStackThatIsSeenDirectly) {
  const Calibration design = Design(), built = Misaligned(design, Most(), 3);
  const LayerCalibration& still = built.layers[1];
  EXPECT_EQ(still.display_from_stack.translation, Eigen::Vector3d::Zero());
  EXPECT_EQ(still.display_from_stack.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0);
  EXPECT_EQ(still.modulator->scale, 0);
  EXPECT_NE(still.emitter.scale, 0);
}

TEST(Misaligned, MovesAndMagnifiesThePlanesOfOneLensSheet) {
  LayerCalibration sheet;
  sheet.emitter.width_px = 1024;
  sheet.emitter.height_px = 768;
  sheet.emitter.pitch_mm = 0.163;
  sheet.gap_mm = 3;
  sheet.lattice.emplace();
  sheet.lattice->pitch_mm = 2.1;
  sheet.lattice->focal_mm = 3;
  Calibration design{"planes", std::vector<LayerCalibration>(24, sheet)};
  for (std::size_t k = 0; k < 24; ++k) {
    design.layers[k].display_from_stack.translation.z() = 8 * static_cast<double>(k) - 92;
  }
  Misalignment by;
  by.shift_mm = 2;
  const Calibration built = Misaligned(design, by, 1, true);
  double widest_shift = 0;
  EXPECT_THROW(Misaligned(design, {}, 1, true), Error);  // 20 mm: not in their order
  by.most_gap_mm = 4;
  EXPECT_THROW(Misaligned(design, by, 1, true), Error);
  for (std::size_t k = 0; k < built.layers.size(); ++k) {
    const LayerCalibration &plane = built.layers[k], &was = design.layers[k];
    const double larger = 1 + plane.emitter.scale;
    EXPECT_NE(larger, 1);
    EXPECT_LE(std::abs(larger - 1), 0.005);
    EXPECT_NEAR(plane.lattice->pitch_mm, larger * was.lattice->pitch_mm, 1e-12);
    EXPECT_NEAR(plane.lattice->focal_mm, larger * larger * 3, 1e-12);
    EXPECT_NEAR(plane.gap_mm, larger * larger * was.gap_mm, 1e-12);
    EXPECT_EQ(plane.offset_mm, was.offset_mm);
    EXPECT_EQ(plane.rotation_rad, was.rotation_rad);
    widest_shift = std::max(widest_shift, std::abs(plane.display_from_stack.translation.z() -
                                                   was.display_from_stack.translation.z()));
  }
  EXPECT_LE(widest_shift, 2);
  EXPECT_GT(widest_shift, 1.5);
}

TEST(Misaligned, IsTheSeeds) {
  const Calibration design = Design();
  EXPECT_EQ(Misaligned(design, {}, 4).layers[0].offset_mm,
            Misaligned(design, {}, 4).layers[0].offset_mm);
  EXPECT_NE(Misaligned(design, {}, 4).layers[0].offset_mm,
            Misaligned(design, {}, 5).layers[0].offset_mm);
  EXPECT_EQ(Misaligned(design, {}, 4).layers[0].gap_mm, 6);
}

TEST(Misaligned, RefusesWhatCannotBe) {
  Misalignment by = Most();
  by.least_gap_mm = 12;
  EXPECT_THROW(Misaligned(Design(), by, 1), Error);
  by = Most();
  by.turn_deg = std::nan("");
  EXPECT_THROW(Misaligned(Design(), by, 1), Error);
}

}  // namespace
}  // namespace lamella
