// Adds nodes' samples to the emitters of all layers: the nearest layer's choice
// (distribute/assign.h) and the sparse matrix product of distribute/prefilter.h, first along rows
// and then down columns, by bands of emitter rows.
#pragma once

#include <span>
#include <vector>

#include "distribute/assign.h"
#include "distribute/prefilter.h"
#include "lightfield/image.h"
#include "lightfield/ray_source.h"

namespace lamella {

// Light times coverage, and coverage; sums of such.
struct alignas(16) Light {
  float r = 0, g = 0, b = 0, coverage = 0;
};

// The emitters of rows [first_row, ...) of all time slots of a layer, slots[slots_per_axis * slot_y
// + slot_x]. Columns may have any order; Overlap::emitter of columns names their places in it.
struct EmitterSums {
  int slots_per_axis = 1;
  int first_row = 0;
  std::vector<Image<Light>> slots;
};

// Of a row of emitters in a slot (both axes' number, as in EmitterSums) that have beams of their
// own along both axes (distribute/calibrated_beams.h); Overlap::emitter is their column.
struct OwnOverlaps {
  int slot = 0, row = 0;
  AxisOverlaps x, y;
};

// What a layer takes of a scene's rays: a product of axes, or emitters' own overlaps.
struct LayerOverlaps {
  std::vector<AxisOverlaps> x;   // by family of columns
  AxisOverlaps y;                // of the rows of the sums
  std::vector<OwnOverlaps> own;  // instead of x and y
  Image<Light> taken;            // room for what is taken of a node's samples
};

// A node's samples; the first one has these indices on the sample lattice.
struct NodeSamples {
  int node_x = 0;
  int first_x = 0, first_y = 0;
  ImageSpan<const RaySample> samples;
};

// A layer's overlaps and sums.
struct LayerSums {
  LayerOverlaps overlaps;
  EmitterSums sums;
};

// Nodes of a row whose light is added up along rows together: 0 and 1, 2 and 3 and so on. Where
// none of these are parted, sums have the same bits however many nodes come at a time.
inline constexpr int kNodesTogether = 2;

// Nodes of one row of nodes, rising; many at a time are faster, since they share emitters. A layer
// takes a sample by its weight, black where another layer shows it (a shadow), and not at all where
// it is unknown or not finite. The samples cover those of all overlaps. Parallel over layers and
// bands of emitter rows.
void Accumulate(std::span<const NodeSamples> nodes, int node_y, const LayerWeights& weights,
                std::span<LayerSums> layers);

}  // namespace lamella
