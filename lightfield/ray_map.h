// The ray map of a barrier, or of a bare panel: the beam of every emitter of a layer in every time
// slot, and its inverse. Barriers on square lattices are separable: the map is a product of one map
// per axis. Lenses have maps of their own (lenslet_map.h, lenticular_map.h); layer_map.h has all in
// one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lightfield/beam.h"
#include "lightfield/display.h"

namespace lamella {

// Emitters by which the window of an opening at x_mm is shifted so that its fan aims at the point
// distance_mm in front of the middle: floor(x d0/(D p) + 1/2).
int ShearShiftPx(double x_mm, double d0_mm, double distance_mm, double pitch_mm);

// What a line of sight meets on one axis.
struct AxisHit {
  int slot = 0;     // the first one in which the modulator is open there
  int element = 0;  // modulator column (from the left) or row (from the top)
  int emitter = 0;  // emitter column or row behind it
  std::uint32_t open_slots =
      0;  // bit s is set where slot s opens it: several where aperture > stride
};

class RayMap {
 public:
  RayMap(const Display& display, int layer);  // UsageError where the layer has lenses

  int slots_per_axis() const { return barrier_.slots; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double position_mm() const { return position_mm_; }
  double d0_mm() const { return d0_mm_; }

  // Centre of an emitter or modulator column (x) or row (y). Nothing else adds a half.
  double ColumnCentre(int column) const { return Centre(x_, column); }
  double RowCentre(int row) const { return Centre(y_, row); }

  // The beam of an emitter column (x) or row (y, up) in a slot; nothing where its opening does not
  // lie on the panel whole. Windows are shifted by ShearShiftPx, D being the viewer's distance from
  // the modulating plane. An emitter that two windows claim where the shear steps is the nearer
  // opening's, the lower index where equally near. One that is missed between two windows would be
  // a dark line: the opening whose unrounded window is nearest sends it along its true ray.
  std::optional<AxisBeam> Column(int slot_x, int column) const { return Beam(x_, slot_x, column); }
  std::optional<AxisBeam> Row(int slot_y, int row) const { return Beam(y_, slot_y, row); }

  // Whether the modulator is open there in a slot. Openings that the panel's edge cuts stay closed.
  bool ColumnOpen(int slot_x, int column) const { return Open(x_, slot_x, column); }
  bool RowOpen(int slot_y, int row) const { return Open(y_, slot_y, row); }

  // What the line of sight through (x_mm, position_mm) with slope dx/dz meets; nothing where it
  // passes beside the modulator or the emitters, or where no slot opens the modulator.
  std::optional<AxisHit> SeenColumn(double x_mm, double slope) const {
    return Seen(x_, x_mm, slope);
  }
  std::optional<AxisHit> SeenRow(double y_mm, double slope) const { return Seen(y_, y_mm, slope); }
  // Also where no slot opens the modulator: open_slots is 0 there.
  std::optional<AxisHit> MetColumn(double x_mm, double slope) const { return Met(x_, x_mm, slope); }
  std::optional<AxisHit> MetRow(double y_mm, double slope) const { return Met(y_, y_mm, slope); }
  // Both axes in one.
  std::optional<LayerHit> See(double x_mm, double y_mm, double slope_x, double slope_y) const;

 private:
  struct Axis {
    int count = 0;    // emitters
    double sign = 1;  // +1: index runs with the coordinate (columns), -1: against it (rows)
    std::vector<std::uint32_t> open_slots;  // of every modulator element
  };
  Axis MakeAxis(int count, double sign) const;
  double Centre(const Axis& axis, int index) const;
  double OpeningCentrePx(const Axis& axis, int opening, int slot) const;
  int ShearShift(const Axis& axis, int opening, int slot) const;
  bool Whole(const Axis& axis, int opening, int slot) const;
  bool Open(const Axis& axis, int slot, int index) const;
  std::optional<int> OpeningOf(const Axis& axis, int slot, int index) const;
  std::optional<AxisBeam> Beam(const Axis& axis, int slot, int index) const;
  std::optional<AxisHit> Met(const Axis& axis, double position, double slope) const;
  std::optional<AxisHit> Seen(const Axis& axis, double position, double slope) const;

  int columns_ = 0, rows_ = 0;
  double pitch_mm_ = 0, position_mm_ = 0, d0_mm_ = 0;
  double shear_distance_mm_ = 0;  // D - z_l; 0: no shear
  double viewer_mm_ = 0;          // D - z_l
  double eye_box_mm_ = 0;         // of a bare panel; 0: it has a barrier
  Barrier barrier_;
  Axis x_, y_;
};

}  // namespace lamella
