// Where virtual photographs of a display are taken from. The world is the display's frame, mm.
#pragma once

#include <string>
#include <vector>

#include "lightfield/calibration.h"
#include "lightfield/view.h"
#include "pipeline/synth_photos.h"

namespace lamella {

// The options' transforms.json, eyes or rings; UsageError where none or several are asked for, or
// one can't be understood. Names are unique.
std::vector<View> PhotoCameras(const SynthPhotosOptions& options, const Calibration& calibration);

}  // namespace lamella
