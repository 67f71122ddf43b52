// The capture of a workspace in a display's volume (distribute/place.h): what the stage layers and
// quilts are made from.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "distribute/place.h"
#include "lightfield/view.h"
#include "pipeline/workspace.h"

namespace lamella {

// `views`: those of the workspace. Where the options give no range of depths, that of all depth
// maps as far as the reference view's picture shows it. UsageError and InputError as ReferenceView,
// ChooseDepthRange and Place have them, InputError where a depth map can't be read.
Placement PlaceCapture(const Workspace& workspace, const std::vector<View>& views,
                       const Display& display, const PlacementOptions& options, std::string* note);

// As a report shows it: what, value.
std::vector<std::pair<std::string, std::string>> SummaryOf(const Placement& placement);

}  // namespace lamella
