// analysis.json (docs/formats.md): what `lamella analyze` says of a display, and of a capture on
// it.
#pragma once

#include <optional>
#include <string>

#include "distribute/analyze.h"
#include "distribute/analyze_scene.h"
#include "lightfield/display.h"
#include "pipeline/workspace.h"

namespace lamella {

// A capture's figures and where they come from.
struct SceneAnalysis {
  std::string reference_view;
  std::string placed_for;  // the display of W/layers, which decided where the scene lies
  double viewing_distance_mm = 0;
  SceneFigures figures;
};

// Where the workspace's scene reaches in the display, from far to near: to decide which depths are
// worth a look. InputError where the workspace has no layers.
DepthInterval SceneDepths(const Workspace& workspace);

// The depths that are worth a look on a display, and the scene's as far as they would not make the
// display's small.
DepthInterval DepthsFor(const Display& display, const DepthInterval& scene);

// Of the reference view that the workspace's layers were made with: its undistorted photograph and
// its depth map. InputError where the stages layers, poses or depth left none.
SceneAnalysis AnalyzeWorkspace(const Workspace& workspace, const Display& display,
                               const Analysis& analysis);

// The JSON's text.
std::string AnalysisJson(const Display& display, const Analysis& analysis,
                         const std::optional<SceneAnalysis>& scene);

}  // namespace lamella
