#include "distribute/direction_lattice.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "lightfield/error.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

template <class Body>
void ForEachLit(const Display& display, const LensletMap& map, const Body& body) {
  for (int y = 0; y < display.emitter_rows(); ++y) {
    for (int x = 0; x < display.emitter_columns(); ++x) {
      if (const std::optional<LensletPixel> pixel = map.Pixel(x, y)) body(x, y, *pixel);
    }
  }
}

}  // namespace

std::array<int, 2> DirectionLattice::BelowHexagonal(int row) const {
  const bool odd = (first_row + row) % 2 != 0;
  const bool shifted = odd == lenses.shift_odd_rows;  // half a pitch right of the next row
  return shifted ? std::array{0, 1} : std::array{-1, 0};
}

DirectionLattice DirectionsOf(const Display& display, int layer) {
  const LensletMap map(display, layer);
  DirectionLattice lattice;
  lattice.lenses =
      std::get<LensletArray>(display.layers.at(static_cast<std::size_t>(layer)).optics);
  constexpr int kMost = std::numeric_limits<int>::max(), kLeast = std::numeric_limits<int>::min();
  int last_column = kLeast, last_row = kLeast;
  lattice.first_column = lattice.first_row = kMost;
  ForEachLit(display, map, [&](int, int, const LensletPixel& pixel) {
    lattice.first_column = std::min(lattice.first_column, pixel.lens.column);
    lattice.first_row = std::min(lattice.first_row, pixel.lens.row);
    last_column = std::max(last_column, pixel.lens.column);
    last_row = std::max(last_row, pixel.lens.row);
  });
  if (last_row == kLeast) {
    throw UsageError(display.name, "no lens lies on the panel whole", "use a larger panel");
  }
  lattice.columns = last_column - lattice.first_column + 1;
  lattice.rows = last_row - lattice.first_row + 1;
  const int rays = lattice.lenses.rays;
  for (int direction = 0; direction < rays * rays; ++direction) {
    lattice.emitters.emplace_back(lattice.columns, lattice.rows, DirectionLattice::kNone);
  }
  ForEachLit(display, map, [&](int x, int y, const LensletPixel& pixel) {
    const int direction = rays * pixel.ray_row + pixel.ray_column;
    lattice.emitters[static_cast<std::size_t>(direction)](pixel.lens.column - lattice.first_column,
                                                          pixel.lens.row - lattice.first_row) =
        y * display.emitter_columns() + x;
  });
  return lattice;
}

std::vector<std::shared_ptr<const DirectionLattice>> DirectionsOfAll(const Display& display) {
  std::vector<std::shared_ptr<const DirectionLattice>> lattices(display.layers.size());
  const auto alike = [&](const Layer& layer) { return layer.optics == display.layers[0].optics; };
  // The shear's windows depend on a layer's distance from the viewer.
  if (!display.shear && std::all_of(display.layers.begin(), display.layers.end(), alike)) {
    std::fill(lattices.begin(), lattices.end(),
              std::make_shared<const DirectionLattice>(DirectionsOf(display, 0)));
    return lattices;
  }
  ParallelForEach(0, static_cast<std::int64_t>(lattices.size()), [&](std::int64_t layer) {
    lattices[static_cast<std::size_t>(layer)] =
        std::make_shared<const DirectionLattice>(DirectionsOf(display, static_cast<int>(layer)));
  });
  return lattices;
}

}  // namespace lamella
