// The loops of making maps consistent: a neighbour's map in this view, and the vote on a pixel's
// candidates. Lanes are pixels, in double precision as the plain formulas have it and without fused
// operations, so that every target gives the bytes of those formulas.
#pragma once

#include <vector>

#include "depth/consistency.h"

namespace lamella {

// What a neighbour's map puts at each pixel of the refined view (nearest pixel, nearest surface)
// and the neighbour's confidence. `warped` has that view's size and is unknown everywhere before.
void WarpMap(const NeighbourMap& from, InverseDepthMap& warped);

// What the pixels of the refined view are decided from.
struct ConsistencyVote {
  const InverseDepthMap& own;
  const std::vector<NeighbourMap>& neighbours;
  const std::vector<InverseDepthMap>& warped;  // by neighbour
  ConsistencyOptions options;
};

// Rows [first_row, last_row) of the vote's result, small components included.
void DecideRows(const ConsistencyVote& vote, int first_row, int last_row, InverseDepthMap& result);

}  // namespace lamella
