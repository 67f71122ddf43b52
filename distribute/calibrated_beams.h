// Emitters whose beams are no product of rows and columns, since their panels stand askew
// (lightfield/calibrated_map.h): each has beams of its own along both axes.
#pragma once

#include <vector>

#include "distribute/accumulate.h"
#include "distribute/emitter_beams.h"
#include "lightfield/calibrated_map.h"

namespace lamella {

// The lit emitters of a row in one time slot: entry i of x and of y is the same emitter, columns
// rise. Offsets are from the plane z = layer_mm.
struct RowOfBeams {
  std::vector<EmitterBeam> x, y;
};
RowOfBeams BeamsOfRow(const CalibratedMap& map, const Display& display, int layer, int slot,
                      int row);

// Emitters from opening to opening of one slot, or from lens to lens along a row.
double PeriodPx(const Display& display, const Layer& layer);

// Beams of periods of rows and columns here and there, a little wider than they are: what aims and
// samples others need is at most a period of emitters beyond what these need.
LayerBeams EnclosingBeamsOf(const CalibratedMap& map, const Display& display, int layer);

// Adds the nodes' samples, as a layer takes them, to emitters with overlaps of their own; samples
// beyond those of a node are left out. Parallel over rows.
void AccumulateOwn(std::span<const NodeSamples> nodes, int node_y, const LayerWeights& weights,
                   int layer, LayerSums& sums);

}  // namespace lamella
