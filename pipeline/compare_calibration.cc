#include "pipeline/compare_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

bool SameSize(const PanelCalibration& a, const PanelCalibration& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px;
}

void CheckAlike(const Calibration& a, const Calibration& b) {
  const auto different = [](const std::string& what) {
    return UsageError("", "the calibrations are of two displays: " + what,
                      "give two calibrations of one display");
  };
  if (a.layers.size() != b.layers.size()) {
    throw different(fmt::format("{} and {} layers", a.layers.size(), b.layers.size()));
  }
  for (std::size_t i = 0; i < a.layers.size(); ++i) {
    const LayerCalibration &of_a = a.layers[i], &of_b = b.layers[i];
    if (of_a.modulator.has_value() != of_b.modulator.has_value() ||
        of_a.lattice.has_value() != of_b.lattice.has_value() ||
        (of_a.lattice && of_a.lattice->type != of_b.lattice->type)) {
      throw different(fmt::format("layer {} has other optics", i));
    }
    if (!SameSize(of_a.emitter, of_b.emitter) ||
        (of_a.modulator && !SameSize(*of_a.modulator, *of_b.modulator))) {
      throw different(fmt::format("layer {} has panels of another size", i));
    }
  }
}

// The calibration with its reference stack in the world's origin.
Calibration InReference(const Calibration& calibration, const PanelId& reference) {
  const Rigid reference_from_display =
      Inverse(calibration.layers[static_cast<std::size_t>(reference.layer)].display_from_stack);
  Calibration moved = calibration;
  for (LayerCalibration& layer : moved.layers) {
    layer.display_from_stack = reference_from_display * layer.display_from_stack;
    if (layer.plate) layer.plate->normal = reference_from_display.rotation * layer.plate->normal;
  }
  return moved;
}

struct Turn {
  double tilt_deg = 0, rotation_deg = 0;
};
Turn TurnBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::AngleAxisd turn(a * b.inverse());
  const Eigen::Vector3d degrees = kDegrees * turn.angle() * turn.axis();
  return {degrees.head<2>().norm(), std::abs(degrees.z())};
}

LayerDifference Difference(const LayerCalibration& a, const LayerCalibration& b) {
  LayerDifference difference;
  difference.stack_shift_mm =
      (a.display_from_stack.translation - b.display_from_stack.translation).norm();
  const Turn stacks = TurnBetween(a.display_from_stack.rotation, b.display_from_stack.rotation);
  difference.stack_tilt_deg = stacks.tilt_deg;
  difference.stack_rotation_deg = stacks.rotation_deg;
  difference.offset_mm = (a.offset_mm - b.offset_mm).norm();
  difference.gap_mm = std::abs(a.gap_mm - b.gap_mm);
  const Turn emitters = TurnBetween(StackFromEmitter(a).rotation, StackFromEmitter(b).rotation);
  difference.tilt_deg = emitters.tilt_deg;
  difference.rotation_deg = emitters.rotation_deg;
  return difference;
}

RayDifference CompareMaps(const Calibration& a, const Calibration& b, const PanelId& reference,
                          const std::vector<ProbedRay>& rays) {
  return CompareRays(PixelsOfRays(a, reference, rays), PixelsOfRays(b, reference, rays));
}

// The emitter's point, in its stack, that an eye sees through the middle of a lens.
std::optional<Eigen::Vector2d> SeenThrough(const LayerCalibration& layer, const LayerSights& sights,
                                           const Eigen::Vector3d& eye,
                                           const Eigen::Vector2d& lens) {
  const Eigen::Vector3d at = layer.display_from_stack * Eigen::Vector3d(lens.x(), lens.y(), 0);
  const std::optional<SightHit> hit = sights.Seen(eye, at - eye);
  if (!hit) return std::nullopt;
  return (StackFromEmitter(layer).rotation * PanelPoint(layer.emitter, hit->emitter)).head<2>();
}

RayDifference CompareLenses(const LayerCalibration& a, const LayerCalibration& b,
                            const EyeBox& box) {
  const LayerSights sights_a(a), sights_b(b);
  const LensLattice of_a = a.lattice.value_or(LensLattice{}),
                    of_b = b.lattice.value_or(LensLattice{});
  const Eigen::Vector2d normal(std::cos(of_a.rotation_rad), std::sin(of_a.rotation_rad));
  Eigen::Matrix2Xd seen_a(2, 0), seen_b(2, 0);
  for (const Eigen::Vector3d& eye : box.Eyes()) {
    for (int i = 0; i < 35; ++i) {
      const int column = i % 7, row = i / 7;
      const Eigen::Vector2d pixel(a.emitter.width_px * (column / 6.0),
                                  a.emitter.height_px * (row / 4.0));
      const Eigen::Vector3d above = StackFromEmitter(a) * PanelPoint(a.emitter, pixel);
      const Eigen::Vector2d lens = NearestLens(of_a, above.head<2>());
      const auto by_a = SeenThrough(a, sights_a, eye, lens);
      const auto by_b = SeenThrough(b, sights_b, eye, NearestLens(of_b, lens));
      if (!by_a || !by_b) continue;
      Eigen::Vector2d apart = (*by_b - *by_a) / a.emitter.pitch_mm;
      if (of_a.type == LensLattice::Type::kLine) apart = normal.dot(apart) * normal;
      seen_a.conservativeResize(2, seen_a.cols() + 1);
      seen_b.conservativeResize(2, seen_b.cols() + 1);
      seen_a.rightCols<1>().setZero();
      seen_b.rightCols<1>() = apart;
    }
  }
  return CompareRays(seen_a, seen_b);
}

}  // namespace

CalibrationComparison CompareCalibrations(const Calibration& a, const Calibration& b,
                                          const EyeBox& box) {
  CheckAlike(a, b);
  const Structure structure = StructureOf(a);
  CalibrationComparison comparison;
  comparison.reference = structure.reference;
  const Calibration here = InReference(a, structure.reference);
  const Calibration there = InReference(b, structure.reference);
  for (std::size_t i = 0; i < here.layers.size(); ++i) {
    const LayerDifference& layer =
        comparison.layers.emplace_back(Difference(here.layers[i], there.layers[i]));
    comparison.gap_mm = std::max(comparison.gap_mm, layer.gap_mm);
    comparison.rotation_deg =
        std::max({comparison.rotation_deg, layer.rotation_deg, layer.stack_rotation_deg});
    comparison.tilt_deg = std::max({comparison.tilt_deg, layer.tilt_deg, layer.stack_tilt_deg});
    if (!here.layers[i].lattice) continue;
    comparison.lenses.push_back(
        {static_cast<int>(i), CompareLenses(here.layers[i], there.layers[i], box)});
  }
  const std::vector<ProbedRay> all = RaysToProbe(structure, box);
  comparison.rays = CompareMaps(here, there, structure.reference, all);
  for (const PanelId& panel : structure.panels) {
    if (panel == structure.reference) continue;
    std::vector<ProbedRay> rays = all;
    std::erase_if(rays, [&](const ProbedRay& ray) { return ray.panel != panel; });
    comparison.panels.push_back({panel, CompareMaps(here, there, structure.reference, rays)});
  }
  return comparison;
}

}  // namespace lamella
