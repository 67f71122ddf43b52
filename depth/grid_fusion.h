// Making the disparity maps of a camera grid agree.
#pragma once

#include <vector>

#include "depth/grid_depth.h"

namespace lamella {

struct GridNeighbour {
  const DisparityMap* map = nullptr;
  int columns = 0, rows = 0;  // steps from the view that is fused
};

struct FusionTolerance {
  double agree_px = 0.15;   // of disparity per step: one surface
  double merge_px = 0.075;  // averaged
};

// For each pixel, the candidates are its own disparity and those that the neighbours' maps, warped
// into this view (nearest pixel, nearest surface), put there. A candidate's score is the number of
// maps that agree with it where it lies in them, minus the number of views that see through it
// (their disparity there is smaller); views in which something nearer stands before it are neutral.
// The pixel's own candidate has half a vote more. The best candidate is averaged with all that are
// within merge_px of it. Confidence: that of what was averaged, times min(1, agreeing maps / 3).
DisparityMap FuseGridView(const DisparityMap& own, const std::vector<GridNeighbour>& neighbours,
                          const FusionTolerance& tolerance);

// The views that `reference` is fused with: up to eight, the nearest of those that lie a multiple
// of a spacing from it in row and column. The spacing is `reach` steps (or that of the nearest
// view), or less where the grid is too small for that: maps of views far apart have independent
// errors.
std::vector<int> ChooseFusionViews(const std::vector<View>& views, int reference, int reach);

}  // namespace lamella
