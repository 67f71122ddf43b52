// What Algorithms 1 and 2 have in common: a world that was placed is distributed to the layers of a
// display, and the stage's files are written.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "distribute/distribute.h"
#include "lightfield/progress.h"
#include "lightfield/ray_source.h"
#include "pipeline/layers_record.h"
#include "pipeline/workspace.h"

namespace lamella {

// The display with what the options change of it. UsageError where it does not exist or can't work.
Display DisplayFor(const LayersOptions& options);

// The calibration that the options name, or none. InputError where it can't be used or is of
// another display.
std::optional<Calibration> CalibrationFor(const LayersOptions& options, const Display& display);

// `record` has the display, its calibration and the placement; the shares that are seen are added.
// `world` is let go before files are written. `note`: a warning of the placement, or empty.
StageReport MakeLayers(std::unique_ptr<const RaySource> world, LayersRecord record,
                       const LayersOptions& options, const std::string& note, StageRun& run,
                       Progress& progress);

}  // namespace lamella
