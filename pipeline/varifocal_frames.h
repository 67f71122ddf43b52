// A varifocal display's frames in W/frames: packed one-bit planes, a file per stroke.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "distribute/distribute.h"
#include "distribute/encode_varifocal.h"
#include "distribute/one_bit.h"
#include "lightfield/display.h"

namespace lamella {

// What frames.json says of them.
struct StrokeFrames {
  std::vector<std::string> files;  // by stroke
  int planes = 0;
  PlanePacking packing;
};

// stroke_NN.png of the layers' luminance, and numerals_N.png to tell a projector's packing by
// (none where the panel is too small for them).
StrokeFrames WriteStrokeFrames(const std::filesystem::path& folder, const LayerImages& layers,
                               const Display& display, const OneBitOptions& options,
                               const PlanePacking& packing, std::vector<std::string>& numerals);

// What frames.json in `folder` says; nothing where the planes are grey, or there are none.
// InputError where it is absent or damaged.
std::optional<StrokeFrames> LoadStrokeFrames(const std::filesystem::path& folder,
                                             const Display& display);

// The share of the strokes in which each emitter is on, by plane. InputError where a file is not of
// the panel's size or not in that packing.
std::vector<Image<float>> ReadStrokeFrames(const std::filesystem::path& folder,
                                           const StrokeFrames& frames, const Display& display);

}  // namespace lamella
