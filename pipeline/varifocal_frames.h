// A varifocal display's frames in W/frames: packed one-bit planes, a file per stroke.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "distribute/emitter_strip.h"
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

// The planes' grey (GreyOf), read by rows: a quarter of what their emitters take.
std::vector<Image<float>> ReadGrey(const OpenEmitters& emitters, const Display& display);

// stroke_NN.png of the planes' grey, and numerals_N.png to tell a projector's packing by (none
// where the panel is too small for them). The grey is let go before files are written.
StrokeFrames WriteStrokeFrames(const std::filesystem::path& folder, std::vector<Image<float>> grey,
                               const Display& display, const OneBitOptions& options,
                               const PlanePacking& packing, std::vector<std::string>& numerals);

// What frames.json in `folder` says; nothing where the planes are grey, or there are none.
// InputError where it is absent or damaged.
std::optional<StrokeFrames> LoadStrokeFrames(const std::filesystem::path& folder,
                                             const Display& display);

// By plane, in how many strokes each emitter is on. InputError where a file is not of the panel's
// size or not in that packing.
std::vector<Image<std::uint16_t>> CountStrokes(const std::filesystem::path& folder,
                                               const StrokeFrames& frames, const Display& display);
// The shares of the strokes that the counts 0, 1 ... are.
std::vector<float> SharesOfStrokes(const StrokeFrames& frames);

}  // namespace lamella
