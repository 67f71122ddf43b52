// Adds one node's samples to the emitters of one layer: the sparse matrix product of
// distribute/prefilter.h, first along rows and then along columns, by bands of emitter rows.
#pragma once

#include <vector>

#include "distribute/prefilter.h"
#include "lightfield/image.h"

namespace lamella {

// Light times coverage, and coverage; sums of such.
struct alignas(16) Light {
  float r = 0, g = 0, b = 0, coverage = 0;
};

// Emitters of all time slots of a layer: slots[slots_per_axis * slot_y + slot_x].
struct EmitterSums {
  int slots_per_axis = 1;
  std::vector<Image<Light>> slots;
};

// `samples`: of the node's bundle, whose first column and row have the indices `first_x`, `first_y`
// on the sample lattice; they cover every sample of the overlaps. Parallel over bands of emitter
// rows.
void Accumulate(ImageSpan<const Light> samples, int first_x, int first_y, const AxisOverlaps& x,
                int node_x, const AxisOverlaps& y, int node_y, EmitterSums& sums);

}  // namespace lamella
