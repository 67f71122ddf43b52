// Algorithm 2 of Ranieri et al. 2012: a generated scene's rays to the layers of a display, without
// a capture between them.
#pragma once

#include <string>
#include <vector>

#include "distribute/distribute.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"
#include "pipeline/workspace.h"

namespace lamella {

struct SynthLayersOptions {
  std::string scene;     // a scene's name or a recipe
  LayersOptions layers;  // as of the stage layers
  std::string like;      // a workspace whose display and placement are used
};
std::vector<OptionTable> Describe(SynthLayersOptions& options);

// Leaves `workspace`/layers as the stage layers does, so that frames and the prototype go on from
// there. The scene is placed as the capture of its own cameras would be: the reference view among
// them, the range of depths that it sees. The workspace's other stages are not touched.
// UsageError where the scene or the display is unknown, InputError where `like` has no layers.
StageReport SynthLayers(SynthLayersOptions options, const Workspace& workspace, Progress& progress);

}  // namespace lamella
