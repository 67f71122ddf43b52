// Depth for every view of a capture: read this first.
//
// A regular camera grid (FindRegularGrid) is matched along its rows and columns (grid_depth.h); any
// other capture by a sweep of planes over each view's best neighbours (sweep_depth.h). Both cost
// volumes go through semi-global matching (sgm.h). A second pass makes the views' maps agree: what
// several views confirm is kept and averaged (grid_fusion.h, consistency.h).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lightfield/depth_map.h"
#include "lightfield/image.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"
#include "lightfield/view.h"

namespace lamella {

// The presets are sets of these: ApplyQuality.
struct DepthOptions {
  std::string source = "estimate";  // or "given": the depth that came with the capture
  int median_radius = 3;            // px

  // Camera grids.
  int fusion_passes = 1;
  int grid_reach = 4;
  int grid_views_per_side = 4;
  bool grid_color = true;
  double grid_step_px = 0.26;
  std::optional<double> disparity_min, disparity_max;

  // Photographs.
  int sweep_size_px = 1536;
  int sweep_labels = 256;
  double sweep_step_px = 2.4;
  int sweep_sources = 4;
  double sweep_angle_deg = 15;
  int check_passes = 2;
  int check_views = 6;
  int check_agreeing = 2;
  double check_tolerance = 0.01;
};

OptionTable Describe(DepthOptions& options);
void ApplyQuality(Quality quality, DepthOptions& options);

// Where the estimate finds photographs and keeps maps between its passes, so that it touches no
// disk itself and an interrupted estimate can be taken up again.
// Photographs and maps are read by many threads, and a map may be saved meanwhile.
class DepthStore {
 public:
  virtual ~DepthStore() = default;
  virtual Image<Rgb8> Photograph(int view) = 0;    // of the camera's size
  virtual bool Has(int pass, int view) const = 0;  // saved before, perhaps by an earlier run
  virtual DepthMap Load(int pass, int view) = 0;   // exactly as it was saved
  virtual void Save(int pass, int view, const DepthMap& map) = 0;
};

// What the estimate says of itself.
struct DepthReport {
  std::vector<std::pair<std::string, std::string>> summary;
  std::vector<std::string> warnings;
};

// Maps of pass 0 are each view's own; those of the last pass are the result.
int NumDepthPasses(const ViewSet& set, const DepthOptions& options);

// Saves the last pass of every view that the store does not have yet (nothing is done where it has
// all), view by view; earlier passes as they are needed for that. A map may be smaller than its
// photograph: Resized(camera, scale) relates them. Depth is 0 where it is unknown and +inf at
// infinity. On a grid every pixel has a value, with its doubt in the confidence; a photograph's
// pixels that other views do not confirm are unknown.
DepthReport EstimateDepth(const ViewSet& set, const DepthOptions& options, DepthStore& store,
                          Progress& progress);

}  // namespace lamella
