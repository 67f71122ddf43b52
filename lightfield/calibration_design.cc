// A display as designed, in the numbers of a calibration.
#include <cmath>
#include <numbers>

#include "lightfield/calibration.h"

namespace lamella {
namespace {

constexpr double kPi = std::numbers::pi;

double Phase(double lenses) { return lenses - std::floor(lenses); }

// Lens centres of displays.md section 3, given in emitters from the top left corner, in mm from the
// middle with y up. All is of the panel; a relay magnifies it afterwards.
LensLattice LatticeOf(const Display& display, const LensletArray& lenses) {
  const double p = display.emitter_pitch_mm(), row = lenses.row_pitch_px();
  const bool hexagonal = lenses.lattice == LensletArray::Lattice::kHexagonal;
  const bool first_row_shifted = hexagonal && !lenses.shift_odd_rows;
  const double x = (first_row_shifted ? 1 : 0.5) * lenses.pitch_px + lenses.offset_x_px -
                   display.emitter_columns() / 2.0;
  const double y = display.emitter_rows() / 2.0 - row / 2 - lenses.offset_y_px;
  LensLattice lattice;
  lattice.pitch_mm = lenses.pitch_px * p;
  lattice.focal_mm = lenses.focal_mm;
  if (!hexagonal) {
    lattice.phase = {Phase(x / lenses.pitch_px), Phase(y / row)};
    return lattice;
  }
  // Rows lie along x: normals at 30 and 90 degrees.
  lattice.type = LensLattice::Type::kHexagonal;
  lattice.rotation_rad = kPi / 6;
  lattice.phase = {Phase((x * std::cos(kPi / 6) + y * std::sin(kPi / 6)) / row), Phase(y / row)};
  return lattice;
}

// van Berkel: sub-pixel k of row l lies (k + k_off - 3 l tan alpha) mod X from its lens's left
// edge.
LensLattice LatticeOf(const Display& display, const Lenticular& lenses) {
  const double p = display.pitch_mm, slant = std::atan(lenses.slant);
  const double X = lenses.subpixels_per_lens;
  // The first lens's axis in the first row, where sub-pixel k is centred on k + 1/2.
  const double x = ((X / 2 - lenses.offset_subpx + 0.5) / 3 - display.width_px / 2.0) * p;
  const double y = (display.height_px / 2.0 - 0.5) * p;
  LensLattice lattice;
  lattice.type = LensLattice::Type::kLine;
  lattice.pitch_mm = X * p / 3 * std::cos(slant);
  lattice.rotation_rad = slant;
  lattice.phase = {Phase((x * std::cos(slant) + y * std::sin(slant)) / lattice.pitch_mm), 0};
  lattice.focal_mm = lenses.focal_mm;
  return lattice;
}

LayerCalibration LayerAsDesigned(const Display& display, const Layer& layer) {
  LayerCalibration design;
  design.display_from_stack.translation = {0, 0, layer.position_mm};
  design.emitter.width_px = display.width_px;
  design.emitter.height_px = display.height_px;
  design.emitter.pitch_mm = display.pitch_mm;
  design.emitter.scale = layer.magnification - 1;
  design.emitter.mirror_x = layer.mirror_x;
  design.emitter.photometry.black = 1 / display.contrast;
  // A relay's image of the gap is in air, and lenses are described by their reduced gap.
  const bool glass = std::holds_alternative<Barrier>(layer.optics) && layer.magnification == 1;
  design.index = glass ? layer.index : 1;
  design.gap_mm = layer.d0_mm * design.index;
  design.gain = 1 / static_cast<double>(display.layers.size());
  if (const auto* lenslets = std::get_if<LensletArray>(&layer.optics)) {
    design.lattice = LatticeOf(display, *lenslets);
  } else if (const auto* lenticular = std::get_if<Lenticular>(&layer.optics)) {
    design.lattice = LatticeOf(display, *lenticular);
    design.emitter.rgb_stripes = true;
  } else if (std::holds_alternative<Barrier>(layer.optics)) {
    design.modulator = design.emitter;
    design.modulator->photometry.black = 1 / std::get<Barrier>(layer.optics).contrast;
  }
  if (layer.plate) {
    const auto& [x, y, z] = layer.plate->normal;
    design.plate =
        Plate{layer.plate->thickness_mm, layer.plate->index, Eigen::Vector3d(x, y, z).normalized()};
  }
  MagnifyOptics(design, layer.magnification);
  return design;
}

}  // namespace

Calibration DesignCalibration(const Display& display) {
  Calibration calibration;
  calibration.display = display.name;
  for (const Layer& layer : display.layers) {
    calibration.layers.push_back(LayerAsDesigned(display, layer));
  }
  return calibration;
}

void MagnifyOptics(LayerCalibration& layer, double larger) {
  layer.gap_mm *= larger * larger;
  if (!layer.lattice) return;
  layer.lattice->pitch_mm *= larger;
  layer.lattice->focal_mm *= larger * larger;
}

}  // namespace lamella
