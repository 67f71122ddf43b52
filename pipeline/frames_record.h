// W/frames: frames.json (docs/formats.md) and the names of the files beside it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "distribute/encode_varifocal.h"
#include "lightfield/display.h"

namespace lamella {

enum class FrameRole { kEmitter, kModulator };

std::string FrameFile(int layer, int slot, FrameRole role);  // layer_K_slot_T_ROLE.png

// A varifocal display's planes of one bit, a packed frame a stroke.
struct StrokeFrames {
  std::string method;  // a name of OneBitMethodNames
  int strokes = 16;
  int planes = 24;
  PlanePacking packing;
  bool numerals = false;  // whether a panel of this size can show them
};

std::string StrokeFile(int stroke);  // stroke_T.png
// numerals.png is for even strokes and numerals_back.png for odd ones, which there and back has.
std::string NumeralsFile(int stroke);
int NumeralStrokes(const StrokeFrames& strokes);  // 1, or 2 there and back

// What a driver of the panels, and a reader of the frames, must know beside the display.
struct FramesRecord {
  std::string curve = "srgb";  // of the panels, or "gamma"; unused by strokes
  double gamma = 2.2;
  std::optional<StrokeFrames> strokes;  // in place of frames by layer and slot
};

void SaveFramesRecord(const std::filesystem::path& folder, const Display& display,
                      const FramesRecord& record);
// Nothing where frames.json is of layers. InputError where it is absent, damaged or of a newer
// version.
std::optional<StrokeFrames> LoadStrokeFrames(const std::filesystem::path& folder);

}  // namespace lamella
