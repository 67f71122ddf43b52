// The beams of a layer's emitters, whatever its optics, as a product of rows and columns: what the
// prefilter needs to treat the axes one after the other.
#pragma once

#include <vector>

#include "lightfield/beam.h"
#include "lightfield/display.h"

namespace lamella {

// Numbers of rows, nodes and layers are ints; containers count otherwise.
inline std::size_t Index(int i) { return static_cast<std::size_t>(i); }

// One axis of an emitter's beam, in the direction of rising indices: along y downwards, against the
// display's y.
struct EmitterBeam {
  int slot = 0;     // on this axis
  int emitter = 0;  // column or row
  int family = 0;   // of a row: the family of columns that its emitters have
  AxisBeam beam;
  double offset_mm = 0;  // of its element in front of the layer's plane (where panels stand askew)
};

// Emitter (column, row) of slot (slot_x, slot_y) has the beam of an entry of `rows` along y and, in
// the family of columns which that names, the entry of its column along x; without both it is dark.
// A barrier has one family of columns, a hexagonal lattice one for either shift of its rows of
// lenses. A slanted lenticular sheet has one for every row; its emitters are sub-pixels, column
// 3 c + channel.
struct LayerBeams {
  std::vector<std::vector<EmitterBeam>> columns;  // by family, each by slot and column
  std::vector<EmitterBeam> rows;                  // by slot and row
};

// Where a sheared window is rounded to whole emitters, its rays go up to half an emitter beside
// where an unrounded window's would.
enum class Directions {
  kTrue,   // those that the emitters really have
  kIdeal,  // the unrounded window's, as the paper has it: pictures jump where the rounding steps
};

// Of a row: the beam whose axis runs down the display, as rows are counted, not up.
AxisBeam Downwards(AxisBeam beam);

// Of the rows [first_row, end_row).
LayerBeams BeamsOf(const Display& display, int layer, int first_row, int end_row,
                   Directions directions = Directions::kTrue);
// Of all rows, in one family where every row has its own (HasRowFamilies): that of beams which
// enclose those of any row.
LayerBeams EnclosingBeamsOf(const Display& display, int layer,
                            Directions directions = Directions::kTrue);

bool HasRowFamilies(const Layer& layer);
// Columns of the emitter sums: of the panel, times 3 where emitters are sub-pixels.
int EmitterColumns(const Display& display, const Layer& layer);

}  // namespace lamella
