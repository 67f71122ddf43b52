// The nearness of every ray of a bundle: the depth maps of the views that know most of it, warped
// forward and merged (depth.md section 4, step 1).
#pragma once

#include <vector>

#include "depth/sight.h"
#include "lightfield/image.h"

namespace lamella {

struct TargetDepthOptions {
  int maps = 3;     // n_f: depth maps that are merged
  int further = 3;  // tried in turn where those leave holes
};

// What the capture's points make of a bundle: quantiles of their nearness along its rays.
struct NearnessRange {
  double far = 0, middle = 0, near = 0;
};
// `geometry` counts nearness from 0.
NearnessRange RangeInBundle(const BundleGeometry& geometry, const std::vector<SourceView>& views);

// The nearnesses, each finite, of the rows [first_row, end_row) of the bundle, where tiles (kTile)
// begin and end. No value depends on which rows are asked for.
Image<float> TargetDepth(const BundleGeometry& geometry, const std::vector<SourceView>& views,
                         const NearnessRange& range, const ViewRanking& ranking,
                         const TargetDepthOptions& options, int first_row, int end_row);

// What TargetDepth allocates for so many rows of a bundle, wherever they lie, at most.
double TargetDepthBytes(int width, int rows);

}  // namespace lamella
