// Where virtual photographs of a display are taken from. The world is the display's frame, mm.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lightfield/calibration.h"
#include "lightfield/rigid.h"
#include "lightfield/view.h"
#include "pipeline/synth_photos.h"

namespace lamella {

// The options' transforms.json, eyes or rings; UsageError where none or several are asked for, or
// one can't be understood. Names are unique.
std::vector<View> PhotoCameras(const SynthPhotosOptions& options, const Calibration& calibration);

// display_from_board of SynthPhotosOptions::printed_board: turned about x, then y, then z. Nothing
// where it is empty; UsageError where it can't be understood.
std::optional<Rigid> PlaceOfPrintedBoard(const std::string& printed_board);

}  // namespace lamella
