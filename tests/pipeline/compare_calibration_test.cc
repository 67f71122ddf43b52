// Calibrations that differ by one number, whose ray error is known in closed form.
#include "pipeline/compare_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

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

// Root mean square and largest tangent of the rays' angles in matter of an index, over 7 x 5 pixels
// of the reference panel and 27 eyes.
RayDifference Tangents(double index) {
  double sum = 0, largest = 0;
  for (const double z : {650, 800, 950}) {
    for (int k = 0; k < 9 * 35; ++k) {
      const int column = k % 7, row = k / 7 % 5, eye_x = k / 35 % 3 - 1, eye_y = k / 105 - 1;
      const double x = (column / 6.0 - 0.5) * 1920 * 0.31125 - 290 * eye_x;
      const double y = (row / 4.0 - 0.5) * 1080 * 0.31125 - 100 * eye_y;
      const double sine2 = (x * x + y * y) / (x * x + y * y + z * z) / (index * index);
      sum += sine2 / (1 - sine2) / (27 * 35);
      largest = std::max(largest, std::sqrt(sine2 / (1 - sine2)));
    }
  }
  return {std::sqrt(sum), largest};
}

TEST(CompareCalibrations, KnowsTheErrorOfAGapAnOffsetAndARotation) {
  const PanelId emitter{1, PanelId::kEmitter};
  Calibration moved = Standard();
  moved.layers[1].gap_mm += 0.1;
  CalibrationComparison result = CompareCalibrations(moved, Standard());
  EXPECT_EQ(result.reference, (PanelId{1, PanelId::kModulator}));
  EXPECT_NEAR(result.gap_mm, 0.1, 1e-12);
  EXPECT_NEAR(RaysTo(result, emitter).rays.rms_px, 0.1 / 0.31125 * Tangents(1.49).rms_px, 1e-6);
  EXPECT_NEAR(RaysTo(result, emitter).rays.max_px, 0.1 / 0.31125 * Tangents(1.49).max_px, 1e-6);
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
  EXPECT_NEAR(RaysTo(result, emitter).rays.rms_px, 1.305, 0.01);
  // 1.305: calibration.md section 8.
  EXPECT_NEAR(result.rotation_deg, 0.1, 1e-9);
  EXPECT_NEAR(result.tilt_deg, 0, 1e-9);

  moved = Standard();
  moved.layers[0].display_from_stack.translation.z() += 0.1;
  result = CompareCalibrations(moved, Standard());
  EXPECT_NEAR(RaysTo(result, {0, PanelId::kModulator}).rays.rms_px,
              0.1 / 0.31125 * Tangents(1).rms_px, 1e-3);
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

// A sheet that is moved by a fifth of a px along its panel, and one whose pitch is 1e-5 wider.
TEST(CompareCalibrations, KnowsWhatEyesSeeThroughLenses) {
  Calibration sheet = Standard();
  sheet.layers.erase(sheet.layers.begin());
  LayerCalibration& layer = sheet.layers[0];
  layer.modulator.reset();
  layer.index = 1;
  for (const auto type : {LensLattice::Type::kLine, LensLattice::Type::kHexagonal}) {
    layer.lattice = LensLattice{type, 10 * 0.31125, 0, {0.25, 0.5}, 0};
    Calibration moved = sheet;
    moved.layers[0].offset_mm.x() += 0.2 * 0.31125;
    const CalibrationComparison offset = CompareCalibrations(sheet, moved);
    ASSERT_EQ(offset.lenses.size(), 1U);
    EXPECT_NEAR(offset.lenses[0].rays.rms_px, 0.2, 1e-9);
    EXPECT_NEAR(offset.lenses[0].rays.max_px, 0.2, 1e-9);
    moved = sheet;
    moved.layers[0].lattice->pitch_mm *= 1 + 1e-5;
    // Of the lens nearest to an edge, and seen from the near eyes.
    const double edge = type == LensLattice::Type::kLine ? 960 : std::hypot(960, 540);
    EXPECT_NEAR(CompareCalibrations(sheet, moved).lenses[0].rays.max_px,
                1e-5 * edge * (1 + 5 / 650.0), 1e-4);
  }
}

}  // namespace
}  // namespace lamella
