// A capture with depth, asked as a RaySource (Algorithm 1's input): depth-aware resampling of its
// views (depth.md section 4).
#pragma once

#include <memory>
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
  double visibility_px = 0.4;  // sv: softness of the visibility test, px of disparity per neighbour
  std::string filter = "catmull_rom";  // or "bilinear"
};

OptionTable Describe(RenderOptions& options);
void ApplyQuality(Quality quality, RenderOptions& options);

struct DepthView {
  View view;         // pinhole
  Image<Rgb> color;  // linear; the camera's size
  DepthMap depth;    // may be smaller than the camera's size (then its camera is Resized)
};

std::unique_ptr<RaySource> CaptureSource(std::vector<DepthView> views,
                                         const RenderOptions& options);

}  // namespace lamella
