#include "distribute/emitter_beams.h"

#include <map>
#include <optional>
#include <utility>

#include "lightfield/layer_map.h"

namespace lamella {
namespace {

const Layer& LayerOf(const Display& display, int layer) {
  return display.layers.at(static_cast<std::size_t>(layer));
}

// Moves the emitters of a sheared window to where the unrounded one has them.
void Idealise(LayerBeams& beams, double distance_mm) {
  const auto move = [distance_mm](AxisBeam& beam, double sign) {
    const double element = sign * beam.element_mm, pitch = beam.emitter_width_mm;
    const double rounded = pitch * ShearShiftPx(element, beam.d0_mm, distance_mm, pitch);
    beam.emitter_mm -= sign * (rounded - element * beam.d0_mm / distance_mm);
  };
  for (std::vector<EmitterBeam>& family : beams.columns) {
    for (EmitterBeam& column : family) move(column.beam, 1);
  }
  for (EmitterBeam& row : beams.rows) move(row.beam, -1);
}

LayerBeams BarrierBeams(const RayMap& map, int first_row, int end_row) {
  LayerBeams beams;
  beams.columns.resize(1);
  for (int slot = 0; slot < map.slots_per_axis(); ++slot) {
    for (int column = 0; column < map.columns(); ++column) {
      if (const auto beam = map.Column(slot, column)) {
        beams.columns[0].push_back({slot, column, 0, *beam});
      }
    }
    for (int row = first_row; row < end_row; ++row) {
      if (const auto beam = map.Row(slot, row)) {
        beams.rows.push_back({slot, row, 0, Downwards(*beam)});
      }
    }
  }
  return beams;
}

// The emitters of one row that lie under one row of lenses.
struct RowUnderLenses {
  std::vector<std::pair<int, double>> places;  // columns, and their lenses' places
  std::vector<EmitterBeam> columns;
  AxisBeam along_y;
};

// Rows of emitters whose columns lie under lenses of the same places share a family.
LayerBeams LensletBeams(const LensletMap& map, int columns, int first_row, int end_row) {
  LayerBeams beams;
  std::map<std::vector<std::pair<int, double>>, int> families;
  for (int row = first_row; row < end_row; ++row) {
    std::map<int, RowUnderLenses> by_lens_row;
    for (int column = 0; column < columns; ++column) {
      const std::optional<Beam> beam = map.BeamOf(column, row);
      if (!beam) continue;
      RowUnderLenses& part = by_lens_row[beam->y.opening];
      part.places.emplace_back(column, beam->x.element_mm);
      part.columns.push_back({0, column, 0, beam->x});
      part.along_y = beam->y;
    }
    for (auto& [lens_row, part] : by_lens_row) {
      const auto [family, is_new] =
          families.emplace(std::move(part.places), static_cast<int>(beams.columns.size()));
      if (is_new) beams.columns.push_back(std::move(part.columns));
      beams.rows.push_back({0, row, family->second, Downwards(part.along_y)});
    }
  }
  return beams;
}

LayerBeams LenticularBeams(const LenticularMap& map, int columns, int first_row, int end_row) {
  LayerBeams beams;
  for (int row = first_row; row < end_row; ++row) {
    std::vector<EmitterBeam>& family = beams.columns.emplace_back();
    for (int column = 0; column < columns; ++column) {
      for (int channel = 0; channel < 3; ++channel) {
        family.push_back({0, 3 * column + channel, 0, map.BeamOf(channel, column, row)->x});
      }
    }
    beams.rows.push_back({0, row, row - first_row, Downwards(map.BeamOf(0, 0, row)->y)});
  }
  return beams;
}

// A beam through all of the lens over a sub-pixel and half of its neighbours, and its whole fan.
LayerBeams EnclosingLenticularBeams(const LenticularMap& map, int columns, int rows) {
  LayerBeams beams;
  beams.columns.resize(1);
  for (int column = 0; column < columns; ++column) {
    AxisBeam beam = map.BeamOf(1, column, 0)->x;
    beam.element_mm = beam.emitter_mm;
    beam.emitter_width_mm = 2 * beam.aperture_mm;
    beam.aperture_mm *= 3;
    beams.columns[0].push_back({0, 3 * column + 1, 0, beam});
  }
  for (int row = 0; row < rows; ++row) {
    beams.rows.push_back({0, row, 0, Downwards(map.BeamOf(0, 0, row)->y)});
  }
  return beams;
}

}  // namespace

AxisBeam Downwards(AxisBeam beam) {
  beam.element_mm = -beam.element_mm;
  beam.emitter_mm = -beam.emitter_mm;
  return beam;
}

bool HasRowFamilies(const Layer& layer) { return std::holds_alternative<Lenticular>(layer.optics); }

int EmitterColumns(const Display& display, const Layer& layer) {
  return display.emitter_columns() * (std::holds_alternative<Lenticular>(layer.optics) ? 3 : 1);
}

LayerBeams BeamsOf(const Display& display, int layer_index, int first_row, int end_row,
                   Directions directions) {
  const Layer& layer = LayerOf(display, layer_index);
  const int columns = display.emitter_columns();
  if (std::holds_alternative<Lenticular>(layer.optics)) {  // no windows
    return LenticularBeams(LenticularMap(display, layer_index), columns, first_row, end_row);
  }
  LayerBeams beams =
      std::holds_alternative<LensletArray>(layer.optics)
          ? LensletBeams(LensletMap(display, layer_index), columns, first_row, end_row)
          : BarrierBeams(RayMap(display, layer_index), first_row, end_row);
  const bool has_windows = !std::holds_alternative<BarePanel>(layer.optics);
  if (directions == Directions::kIdeal && display.shear && has_windows) {
    Idealise(beams, display.distance_mm(layer));
  }
  return beams;
}

LayerBeams EnclosingBeamsOf(const Display& display, int layer, Directions directions) {
  const int rows = display.emitter_rows();
  if (!HasRowFamilies(LayerOf(display, layer))) return BeamsOf(display, layer, 0, rows, directions);
  return EnclosingLenticularBeams(LenticularMap(display, layer), display.emitter_columns(), rows);
}

}  // namespace lamella
