// The lit emitters of a layer under lenslets, sorted by direction: those of one direction (ray
// column, ray row) form a picture with one pixel a lens, and are neighbours of each other. On the
// panel the adjacent emitter is another direction.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

struct DirectionLattice {
  static constexpr int kNone = -1;

  LensletArray lenses;
  int columns = 0, rows = 0;            // of lenses
  int first_column = 0, first_row = 0;  // lattice coordinates (Lens) of the first
  // emitters[lenses.rays * ray_row + ray_column](column, row): the emitter's index, row * emitter
  // columns + column, in the layer's images; kNone where that lens lacks the direction. No emitter
  // is in two places, guard pixels are in none.
  std::vector<Image<int>> emitters;

  int directions() const { return static_cast<int>(emitters.size()); }
  // Columns from `column` to the nearest lens of the next row on the left and on the right of a
  // lens of a hexagonal lattice.
  std::array<int, 2> BelowHexagonal(int row) const;
};

// UsageError where the layer has no lenslets, or none that is whole.
DirectionLattice DirectionsOf(const Display& display, int layer);
// Of all layers; those whose emitters lie alike under the lenses share one.
std::vector<std::shared_ptr<const DirectionLattice>> DirectionsOfAll(const Display& display);

}  // namespace lamella
