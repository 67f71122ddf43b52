// Two workspaces' layers, by what eyes would see of each.
#pragma once

#include <string>
#include <vector>

#include "lightfield/progress.h"
#include "pipeline/preview_measure.h"
#include "pipeline/workspace.h"

namespace lamella {

struct EyeDifference {
  double x_mm = 0, y_mm = 0;  // where the eye is, at the viewing distance
  PreviewMetrics metrics;
};

struct LayersComparison {
  std::vector<EyeDifference> eyes;
  int width = 0, height = 0;  // of the pictures
};

// Eyes in the middle, half way and at the sides and corners of the clean eye box (the smaller of
// the two displays') look at the picture on z = 0, a panel's pixel each, less `border_px` on every
// side. The displays may differ (one layer against two); InputError where they stand at different
// viewing distances or show pictures of different size.
LayersComparison CompareLayers(const Workspace& a, const Workspace& b, int border_px,
                               Progress& progress);

}  // namespace lamella
