// From the photographs of a calibration's patterns to what calibration reads.
#pragma once

#include <filesystem>

#include "calibration/observations.h"
#include "lightfield/progress.h"
#include "pipeline/check_photos.h"

namespace lamella {

// The corners of all good photographs of boards; where a position has all sinusoids of a panel, the
// nodes of their map instead, under the name of their first photograph. `photos` is the folder that
// was checked, its photographs of one camera. InputError where photographs differ in size.
Observations ObservePhotos(const CheckedPhotos& checked, const std::filesystem::path& photos,
                           Progress& progress);

}  // namespace lamella
