// The ray map of a layer whatever its optics: each emitter's beam, and what a line of sight meets.
// One description for encoders, simulated eyes and the virtual prototype.
#pragma once

#include <optional>
#include <variant>

#include "lightfield/beam.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/lenticular_map.h"
#include "lightfield/ray_map.h"

namespace lamella {

class LayerMap {
 public:
  LayerMap(const Display& display, int layer);

  double position_mm() const { return position_mm_; }
  // The beam of an emitter in a time slot (slots_per_axis * slot_y + slot_x; 0 where there is only
  // one), nothing where it is dark. `channel` matters to lenticular lenses.
  std::optional<Beam> BeamOf(int slot, int channel, int column, int row) const;
  // What the line through (x_mm, y_mm) on the modulating plane with slopes dx/dz, dy/dz meets;
  // nothing where that is closed in all slots, no whole lens, or beside the panel.
  std::optional<Sight> See(double x_mm, double y_mm, double slope_x, double slope_y) const;

 private:
  std::variant<RayMap, LensletMap, LenticularMap> map_;
  double position_mm_ = 0;
};

}  // namespace lamella
