// Disparity of the views of a regular camera grid: cost, semi-global matching, median.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "depth/grid_arms.h"
#include "depth/grid_cost.h"
#include "lightfield/image.h"
#include "lightfield/view.h"

namespace lamella {

struct DisparityMap {
  Image<float> disparity;   // px per grid step; every pixel has a value
  Image<float> confidence;  // [0, 1]
};

struct GridOptions {
  int reach = 4;                                       // steps
  int per_arm = 4;                                     // sources on a side
  bool color = true;                                   // else the gradient alone
  double step_px = 0.26;                               // between labels, at the farthest source
  int median_radius = 3;                               // px
  std::optional<double> disparity_min, disparity_max;  // px per step; unset: estimated
};

using LoadPhotograph = std::function<Image<Rgb8>(int view)>;

// The labels of all views of a grid. What the options leave open is measured: a sweep at a quarter
// of the size over every disparity that leaves half of the picture in view, in the central and the
// four outermost views; the range of what is matched with confidence there, a little widened.
DisparityLabels ChooseGridLabels(const std::vector<View>& views, const LoadPhotograph& load,
                                 const GridOptions& options, MatchMemory& memory);

// `images` by view; those of the arms and the reference are read.
DisparityMap EstimateGridView(const std::vector<View>& views, int reference, const GridArms& arms,
                              const std::function<std::shared_ptr<const GridImage>(int)>& images,
                              ImageSpan<const Rgb8> photograph, const DisparityLabels& labels,
                              const GridOptions& options, MatchMemory& memory);

}  // namespace lamella
