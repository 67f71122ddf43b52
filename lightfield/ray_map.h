// The ray map: the beam of every emitter of a layer in every time slot, and its inverse.
//
// Barriers on square lattices are separable: the map is a product of one map per axis.
#pragma once

#include <optional>

#include "lightfield/display.h"

namespace lamella {

// One axis of an emitter's beam: all lines from a point of the emitter, emitter_mm +-
// emitter_width/2 on the emissive plane, through a point of the opening, element_mm +- aperture/2
// on the modulating plane (displays.md sections 1.2 and 1.3). Slope = (element - emitter) / d0.
struct AxisBeam {
  int opening = 0;
  double element_mm = 0;        // centre of the opening
  double aperture_mm = 0;       // w_x, full width
  double emitter_mm = 0;        // centre of the emitter
  double emitter_width_mm = 0;  // w_u, full width
};

// What a line of sight meets on one axis.
struct AxisHit {
  int slot = 0;     // in which the modulator is open there
  int element = 0;  // modulator column (from the left) or row (from the top)
  int emitter = 0;  // emitter column or row behind it
};

class RayMap {
 public:
  RayMap(const Display& display, int layer);

  int slots_per_axis() const { return slots_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double position_mm() const { return position_mm_; }
  double d0_mm() const { return d0_mm_; }

  // The beam of an emitter column (x) or row (y, up) in a slot; nothing where no opening claims it
  // (missed at a step of the shear, or its opening lies off the panel).
  std::optional<AxisBeam> Column(int slot_x, int column) const;
  std::optional<AxisBeam> Row(int slot_y, int row) const;

  // What the line of sight through (x_mm, position_mm) with slope dx/dz meets; nothing off the
  // panel.
  std::optional<AxisHit> SeenColumn(double x_mm, double slope) const;
  std::optional<AxisHit> SeenRow(double y_mm, double slope) const;

 private:
  struct Axis {
    int count = 0;    // emitters
    double sign = 1;  // +1: index runs with the coordinate (columns), -1: against it (rows)
  };
  std::optional<AxisBeam> Beam(const Axis& axis, int slot, int index) const;
  std::optional<AxisHit> Seen(const Axis& axis, double position, double slope) const;

  int columns_ = 0, rows_ = 0, slots_ = 1;
  double pitch_mm_ = 0, position_mm_ = 0, d0_mm_ = 0;
  double shear_distance_mm_ = 0;  // D - z_l; 0: no shear
  Barrier barrier_;
};

}  // namespace lamella
