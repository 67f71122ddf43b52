// Strips of rows in which emitters are made, so that what is allocated meanwhile fits into memory.
#pragma once

#include <vector>

#include "distribute/accumulate.h"
#include "distribute/nodes.h"
#include "lightfield/display.h"
#include "lightfield/ray_source.h"

namespace lamella {

// Rows of emitters that are worked on at a time.
struct Strip {
  int first_row = 0, end_row = 0;
  int rows() const { return end_row - first_row; }
};

// Emitters are given away, and files of them written, in blocks of so many rows.
inline constexpr int kBlockRows = 32;

// What Distribute allocates at most while it works on strips of `rows` rows: the sums of light,
// beams and their overlaps (of every emitter where these have beams of their own), the nodes'
// samples, what the source needs to answer for them, and what threads hold.
double BytesOfStrips(const Display& display, const NodeLattice& nodes, const RaySource& source,
                     bool own_beams, int rows, int nodes_at_a_time = kNodesTogether);

// Of a row of nodes, those whose samples are held at a time while the strips have `rows` rows:
// whole groups of kNodesTogether, as many as fit into `bytes` and are fast (more share emitters'
// sums), but one where nodes share nothing: for emitters' own beams, and for the blur.
int NodesAtATime(const Display& display, const NodeLattice& nodes, const RaySource& source,
                 bool own_beams, int rows, double bytes);

// Even strips of whole blocks: as few as take at most `bytes`; where none does, of one block. Low
// strips take long: what lies around a strip is asked for again for the next one.
std::vector<Strip> StripsOf(const Display& display, const NodeLattice& nodes,
                            const RaySource& source, bool own_beams, double bytes);

}  // namespace lamella
