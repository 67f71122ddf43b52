// Making the depth maps of photographs agree, and leaving unknown what none confirms.
#pragma once

#include <vector>

#include "depth/sweep_depth.h"
#include "lightfield/image.h"

namespace lamella {

// Another view's map, as seen from the view that is refined.
struct NeighbourMap {
  const InverseDepthMap* map = nullptr;
  PictureMap there;  // from the refined view's picture to the neighbour's
  PictureMap back;
};

struct ConsistencyOptions {
  double tolerance = 0.01;  // of inverse depth, relative
  double step = 0;          // 1 / world unit: half a label's step always counts as agreeing
  double return_px = 2;  // largest distance between a pixel and where a neighbour's map leads back
  int agreeing = 2;      // other views that must confirm a pixel
  int min_component = 100;  // px: smaller islands of one surface are removed
};

// For each pixel the candidates are its own inverse depth and those of the neighbours' maps, warped
// into this view (nearest pixel, nearest surface). A neighbour confirms a candidate when its map at
// the place where it shows the point has the same inverse depth (within the tolerance) and leads
// back to within return_px; it contradicts it when its map there lies behind: it sees through. The
// candidate with the most confirmations less contradictions wins, the own one by half a vote, and
// is averaged with the confirming maps; the map that it is from counts neither way. Fewer
// confirmations than asked (than half of the neighbours, where that is less), or islands that are
// too small: unknown.
// Confidence: that of the candidate, times min(1, confirmations / 3).
InverseDepthMap MakeConsistent(const InverseDepthMap& own,
                               const std::vector<NeighbourMap>& neighbours,
                               const ConsistencyOptions& options);

// Marks as unknown the 4-connected components of fewer than `min_pixels` pixels, where neighbours
// are connected when their inverse depths differ by at most `jump`.
void RemoveSmallComponents(InverseDepthMap& map, double jump, int min_pixels);

}  // namespace lamella
