// Which views tell the depth of a view, and between which depths to look.
#pragma once

#include <optional>
#include <vector>

#include "depth/plane_sweep.h"
#include "lightfield/view.h"

namespace lamella {

struct NeighbourOptions {
  int max_sources = 4;
  double max_angle_deg = 15;  // between the rays of the two views, median over what both see
};

// Sources for a view (indices into set.views), best first, taken in turn from either side of the
// view, so that an occluder that hides a point from one side leaves the other. Ranked by the sum
// over common points of exp(-(angle - 10 deg)^2 / (2 sigma^2)), sigma 5 deg below and 15 above
// (after Yao et al. 2018), times (resolution ratio)^2 of coarser views. A view whose median angle
// is under 0.3 deg carries no depth and is left out; one wider than the largest angle is taken only
// where fewer than two are within it. Where the set has no points, the pixels of the view at a
// depth of `range` stand for them.
std::vector<int> ChooseSources(const ViewSet& set, int view, const InverseDepthRange& range,
                               const NeighbourOptions& options);

// The depths of the points that the view sees: the nearest (1 % quantile) less 12 %, the farthest
// (99 %) times 5, since sparse points miss the background and the far end costs few labels. Nothing
// where fewer than 8 points are seen.
std::optional<InverseDepthRange> RangeOfPoints(const ViewSet& set, int view, int labels);

}  // namespace lamella
