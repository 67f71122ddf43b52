// What a display was to be when its patterns were made, and who looks at it.
#pragma once

#include <filesystem>
#include <string>

#include "calibration/shot_list.h"
#include "calibration/uncertainty.h"
#include "lightfield/calibration.h"
#include "lightfield/display.h"

namespace lamella {

struct CalibrationSetUp {
  ShotList list;
  Display display;  // as designed
  Calibration design;
};
// Of the folder that `calibrate patterns` wrote and a display by name or file ("": the folder's
// own). UsageError where the patterns are not of that display.
CalibrationSetUp LoadCalibrationSetUp(const std::filesystem::path& patterns,
                                      const std::string& display);

// UsageError naming `where` unless the panels that the patterns were made for are the design's.
void CheckDesign(const Calibration& design, const ShotList& list, const std::string& where);

// The box in which eyes see the display cleanly, at least 65 mm wide and high, from 0.8 to 1.2
// viewing distances.
EyeBox CleanEyesOf(const Display& display);

}  // namespace lamella
