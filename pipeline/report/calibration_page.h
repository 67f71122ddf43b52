// The page of a calibration: one self-contained file, without scripts, of what it is worth, where
// on its panels, and which photograph to take next.
#pragma once

#include <string>

#include "pipeline/solve_photos.h"

namespace lamella {

std::string CalibrationPage(const SolvedPhotos& solved);

}  // namespace lamella
