// A capture with depth, asked as a RaySource (Algorithm 1's input): depth-aware resampling of its
// views (depth.md section 4).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lightfield/depth_map.h"
#include "lightfield/image.h"
#include "lightfield/options.h"
#include "lightfield/ray_source.h"
#include "lightfield/view.h"

namespace lamella {

struct RenderOptions {
  int views = 4;               // K: inputs that are blended
  int maps = 3;                // n_f: depth maps that are warped to find a ray's depth
  double visibility_px = 0.5;  // sv: softness of the visibility test, px of disparity per neighbour
  std::string filter = "catmull_rom";  // or "bilinear"
  std::string exposure = "auto";  // equalise the views' exposures: auto (photographs only), on, off
  // No options of a user's. Whoever leaves out what was not seen saves the time for its colours;
  // whoever tells about which rays will be asked saves the memory of colours finer than they need.
  bool guess_unseen = true;
  std::optional<RayBundle> rays;
};

OptionTable Describe(RenderOptions& options);
void ApplyQuality(Quality quality, RenderOptions& options);

struct DepthView {
  View view;         // pinhole
  Image<Rgb> color;  // linear; the camera's size
  DepthMap depth;    // may be smaller than the camera's size (then its camera is Resized)
};

// The views are blended with depth-aware visibility. A sample's coverage is the share of its ray's
// footprint that a view saw: its depth says that the ray's point lies on the surface it shows
// there. Rays that no view saw have coverage 0 and a plausible colour, or black where that is not
// asked for. Needs at least one view;
// UsageError where there is none or a picture has not its camera's size.
std::unique_ptr<RaySource> CaptureSource(std::vector<DepthView> views,
                                         const RenderOptions& options);

}  // namespace lamella
