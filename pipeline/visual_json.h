// visual.json: the calibration that every Looking Glass display carries, versions 1.0 to 3.0
// (displays.md section 4).
#pragma once

#include <filesystem>
#include <string>

#include "lightfield/looking_glass.h"

namespace lamella {

struct VisualJson {
  std::string version;  // configVersion
  std::string serial;
  LookingGlass panel;  // pitch, slope, center, DPI, screenW, screenH, flips, cells
  // What cameras are placed by; weaving needs none of it.
  double view_cone_deg = 0;
  double vertical_deg = 0;  // verticalAngle
  double fringe = 0;
  bool invert_views = true;  // invView as the file has it; later versions' renderers ignore it
};

// Numbers may be bare or {"value": x}, and whole ones may be written as reals. What first versions
// lack may be absent: fringe, verticalAngle, the flips and invView (1), CellPatternMode (0) and
// subpixelCells. Unknown fields are left alone, since devices have more. InputError naming file and
// field where one is missing or out of range, or the version is newer than 3.
VisualJson ReadVisualJson(const std::filesystem::path& path);

// As version 3.0; reading gives the same numbers back.
void WriteVisualJson(const std::filesystem::path& path, const VisualJson& visual);

}  // namespace lamella
