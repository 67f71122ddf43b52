// Colours of a tile of rays whose nearness is known, blended from the views that see them.
#pragma once

#include <vector>

#include "depth/blend_kernels.h"
#include "depth/sight.h"
#include "lightfield/image.h"
#include "lightfield/ray_source.h"

namespace lamella {

struct BlendOptions {
  int views = 4;          // blended wherever they see the ray
  int further = 4;        // tried in turn for rays that those do not see
  bool cubic = true;      // Catmull-Rom, else bilinear
  bool guess = true;      // colours of rays that no view sees too, else they stay black
  float color_scale = 1;  // of the views' colours (ColorPyramid's 2^exponent)
};

// A tile's views, best first, and its nearness: of the whole tile, whatever part of it is asked
// for, so that no value depends on the part.
struct TileSights {
  std::vector<Sight> sights;
  float nearness = 0;       // typical
  float far = 0, near = 0;  // smallest, largest
};

// The rays `rays` of a tile (inside of the bundle): their nearness (rays.width x rays.height) to
// their samples.
void BlendTile(const BundleGeometry& geometry, const std::vector<SourceView>& views,
               const TileSights& sights, double neighbour, const BlendOptions& options,
               const Rect& rays, ImageSpan<const float> nearness, ImageSpan<RaySample> samples);

}  // namespace lamella
