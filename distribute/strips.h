// Strips of rows in which emitters are made, so that what is allocated meanwhile fits into memory.
#pragma once

#include <optional>
#include <vector>

#include "distribute/nodes.h"
#include "lightfield/calibrated_map.h"
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
// Nodes whose samples are held at a time: neighbours share emitters; more are hardly faster.
inline constexpr int kNodesAtATime = 2;

// Rows of emitters over which beams of one row are spread, where panels stand askew and every
// emitter has a beam of its own; nothing where there are no maps.
std::optional<int> RowsAskew(const Display& display, const std::vector<CalibratedMap>& maps);

// What Distribute allocates at most while it works on strips of `rows` rows: the sums of light,
// beams and their overlaps (of every emitter where these have beams of their own), the nodes'
// samples, what the source needs to answer for them, and what threads hold.
double BytesOfStrips(const Display& display, const NodeLattice& nodes, const RaySource& source,
                     std::optional<int> rows_askew, int rows);

// Even strips of whole blocks: as few as take at most `bytes`; where none does, those that take
// least and still are no lower than what is asked around them.
std::vector<Strip> StripsOf(const Display& display, const NodeLattice& nodes,
                            const RaySource& source, std::optional<int> rows_askew, double bytes);

}  // namespace lamella
