// Distribution of a scene's rays to a display's layers (Algorithms 1 and 2 of Ranieri et al. 2012
// on one page): read this first.
//
//   for every node of the display's rays: query the source once
//     for every layer: weight_l(z) * colour and coverage, added to the emitters by the exact
//     overlap of their beams with the node's cell
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "distribute/place.h"
#include "lightfield/calibration.h"
#include "lightfield/display.h"
#include "lightfield/image.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"
#include "lightfield/ray_source.h"

namespace lamella {

struct LayersOptions {
  std::string display = "paper-two-layer";  // a preset's name or a file
  PlacementOptions placement;
  int nodes_per_step = 1;            // nodes of the eye plane (or slopes) per emitter step and axis
  int samples_per_pixel = 1;         // rays per emitter pitch and axis in a node's bundle
  std::string kernel = "beam";       // prefilter: beam, lens or ray (distribute/prefilter.h)
  std::string prefilter = "gather";  // or "blur", driven by depth (distribute/depth_blur.h)
  std::string directions = "true";   // or "ideal" (distribute/emitter_beams.h)
  std::string calibration;           // calibration.json of the display; "": as designed
  bool scatter = false;  // nodes and samples within their cells by a low-discrepancy sequence
  std::optional<double> border_mm, border_offset_mm;  // default: the display's
  // Of what distribution allocates; strip by strip where all rows need more. Changes no value.
  double memory_gib = 4;
};
OptionTable Describe(LayersOptions& options);
// --memory, of all stages that work in strips.
OptionField MemoryField(double& gib);
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

// Whole rows of a slot's emitters, from first_row on.
struct EmitterRows {
  int layer = 0, slot = 0, first_row = 0;
  EmitterImage emitters;
};
// Is called from several threads; for one slot in the order of rows, in whole blocks of 32 but for
// the last.
using TakeEmitterRows = std::function<void(EmitterRows)>;

// The rays that an eye in the middle would ask for: as all nodes', about.
RayBundle MiddleRays(const Display& display, const LayersOptions& options);

// UsageError where an option is not for the display, calibrated or as designed.
void CheckOptions(const LayersOptions& options, const Display& display, bool calibrated);

// Bytes that Distribute needs at least, however little memory the options allow it.
double LeastBytes(const RaySource& source, const Display& display, const LayersOptions& options,
                  const Calibration* calibration = nullptr);

// The mean coverage of the display's rays: of all, and of those that pass the picture (all rays
// have one footprint).
struct SeenShares {
  double of_all = 0, of_picture = 0;
};
// A rectangle in the middle of z = 0.
struct PictureSize {
  double width_mm = std::numeric_limits<double>::infinity();
  double height_mm = std::numeric_limits<double>::infinity();
};

// Any optics; of a lenticular sheet each channel of a pixel is an emitter of its own, and their
// mean coverage the pixel's. `source` is placed: it answers in the display's frame. The emitters
// are given away block by block, so that they need not fit into memory. With a calibration, of the
// display (CheckCalibrates), it is the rays that the emitters really have; options.calibration is
// not read here.
SeenShares Distribute(const RaySource& source, const Display& display, const LayersOptions& options,
                      const PictureSize& picture, const TakeEmitterRows& take, Progress& progress,
                      const Calibration* calibration = nullptr);
// All of them at once.
LayerImages Distribute(const RaySource& source, const Display& display,
                       const LayersOptions& options, Progress& progress,
                       const Calibration* calibration = nullptr);

}  // namespace lamella
