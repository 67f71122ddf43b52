// Misaligned displays against the bounds that were asked for.
#include "datasets_synthetic/misalign.h"

#include <cmath>
#include <numbers>

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
