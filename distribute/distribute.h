// Distribution of a scene's rays to a display's layers (Algorithms 1 and 2 of Ranieri et al. 2012
// on one page): read this first.
//
//   for every node of the display's rays: query the source once
//     for every layer: weight_l(z) * colour and coverage, added to the emitters by the exact
//     overlap of their beams with the node's cell
#pragma once

#include <string>
#include <vector>

#include "distribute/place.h"
#include "lightfield/display.h"
#include "lightfield/image.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"
#include "lightfield/ray_source.h"

namespace lamella {

struct LayersOptions {
  std::string display = "paper-two-layer";  // a preset's name or a file
  PlacementOptions placement;
  int nodes_per_step = 1;       // nodes of the eye plane (or slopes) per emitter step and axis
  int samples_per_pixel = 1;    // rays per emitter pitch and axis in a node's bundle
  std::string kernel = "beam";  // prefilter: beam, lens or ray (distribute/prefilter.h)
  bool scatter = false;  // nodes and samples within their cells by a low-discrepancy sequence
  std::optional<double> border_mm, border_offset_mm;  // default: the display's
};
OptionTable Describe(LayersOptions& options);
void ApplyQuality(Quality quality, LayersOptions& options);

// One time slot of one layer: emitters, linear light; coverage 0 = unknown (colour is then black),
// black with coverage 1 = shadow.
struct EmitterImage {
  Image<Rgb> color;
  Image<float> coverage;
};

// slots[layer][slot], slot = slots_per_axis * slot_y + slot_x.
struct LayerImages {
  std::vector<std::vector<EmitterImage>> slots;
  double seen_share = 0;  // of all display rays, weighted by footprint
};

// The mean coverage of the rays that pass a rectangle in the middle of z = 0, over all emitters
// that have a ray (all rays have one footprint).
double SeenShare(const LayerImages& images, const Display& display, double width_mm,
                 double height_mm);

// `source` is placed: it answers in the display's frame.
LayerImages Distribute(const RaySource& source, const Display& display,
                       const LayersOptions& options, Progress& progress);

}  // namespace lamella
