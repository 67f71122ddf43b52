// Calibrations that differ by what calibration.md section 8 has the ray error of.
#include "pipeline/compare_calibration.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Calibration Standard() {
  LayerCalibration layer;
  layer.emitter.width_px = 1920;
  layer.emitter.height_px = 1080;
  layer.emitter.pitch_mm = 0.31125;
  layer.gap_mm = 5;
  layer.index = 1.49;
  Calibration display{"standard", {layer, layer}};
  display.layers[0].emitter.mirror_x = true;
  display.layers[0].display_from_stack.translation.z() = -80;
  display.layers[0].plate = Plate{1, 1.5, {0, std::sqrt(0.5), std::sqrt(0.5)}};
  for (LayerCalibration& each : display.layers) each.modulator = each.emitter;
  return display;
}

const PanelRays& RaysTo(const CalibrationComparison& comparison, PanelId panel) {
  for (const PanelRays& rays : comparison.panels) {
    if (rays.panel == panel) return rays;
  }
  throw std::runtime_error("no such panel");
}

TEST(CompareCalibrations, KnowsTheErrorOfAGapAnOffsetAndARotation) {
  const PanelId emitter{1, PanelId::kEmitter};
  Calibration moved = Standard();
  moved.layers[1].gap_mm += 0.1;
  CalibrationComparison result = CompareCalibrations(moved, Standard());
  EXPECT_EQ(result.reference, (PanelId{1, PanelId::kModulator}));
  EXPECT_NEAR(result.gap_mm, 0.1, 1e-12);
  EXPECT_NEAR(RaysTo(result, emitter).rays.rms_px, 0.086, 0.002);
  EXPECT_NEAR(RaysTo(result, emitter).rays.max_px, 0.162, 0.004);
  EXPECT_EQ(RaysTo(result, {0, PanelId::kModulator}).rays.max_px, 0);
  // A third of the rays differs.
  EXPECT_NEAR(result.rays.rms_px, RaysTo(result, emitter).rays.rms_px / std::sqrt(3), 1e-9);

  moved = Standard();
  moved.layers[1].offset_mm.x() += 0.1;
  result = CompareCalibrations(moved, Standard());
  EXPECT_NEAR(RaysTo(result, emitter).rays.rms_px, 0.321, 0.001);
  EXPECT_NEAR(result.layers[1].offset_mm, 0.1, 1e-12);

  moved = Standard();
  moved.layers[1].rotation_rad.z() += 0.1 * kDegree;
  result = CompareCalibrations(moved, Standard());
  EXPECT_NEAR(RaysTo(result, emitter).rays.rms_px, 1.305, 0.03);
  EXPECT_NEAR(result.rotation_deg, 0.1, 1e-9);
  EXPECT_NEAR(result.tilt_deg, 0, 1e-9);

  moved = Standard();
  moved.layers[0].display_from_stack.translation.z() += 0.1;
  result = CompareCalibrations(moved, Standard());
  EXPECT_NEAR(RaysTo(result, {0, PanelId::kModulator}).rays.rms_px, 0.139, 0.004);
  EXPECT_NEAR(result.layers[0].stack_shift_mm, 0.1, 1e-12);
}

TEST(CompareCalibrations, DependsOnNoFrame) {
  Calibration moved = Standard();
  moved.layers[0].display_from_stack.translation += Eigen::Vector3d(0.1, -0.2, 0.3);
  const CalibrationComparison here = CompareCalibrations(moved, Standard());
  const Rigid there{
      Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized())),
      {400, -30, 900}};
  for (LayerCalibration& layer : moved.layers) {
    layer.display_from_stack = there * layer.display_from_stack;
    if (layer.plate) layer.plate->normal = there.rotation * layer.plate->normal;
  }
  const CalibrationComparison result = CompareCalibrations(moved, Standard());
  EXPECT_NEAR(result.rays.rms_px, here.rays.rms_px, 1e-9);
  EXPECT_NEAR(result.rays.max_px, here.rays.max_px, 1e-9);
  EXPECT_GT(result.rays.rms_px, 0.1);
  EXPECT_NEAR(result.rotation_deg, 0, 1e-9);
}

TEST(CompareCalibrations, RefusesTwoDisplays) {
  Calibration other = Standard();
  other.layers[0].modulator->width_px = 1000;
  EXPECT_THROW(CompareCalibrations(other, Standard()), Error);
  other = Standard();
  other.layers.pop_back();
  EXPECT_THROW(CompareCalibrations(other, Standard()), Error);
  other = Standard();
  other.layers[1].modulator.reset();
  EXPECT_THROW(CompareCalibrations(other, Standard()), Error);
}

}  // namespace
}  // namespace lamella
