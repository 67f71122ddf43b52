// The panels' emissive frames of W/frames, decoded back to the light that their emitters emit.
#pragma once

#include "distribute/distribute.h"
#include "pipeline/layers_record.h"
#include "pipeline/workspace.h"

namespace lamella {

struct PanelImages {
  LayerImages layers;
  bool grey = false;  // the display has no colours
};

// As the display shows them: 8-bit codes through the panels' response, or the mean of one-bit
// strokes; mirrored panels turned back. The coverage is that of the layers. InputError where
// frames.json or a frame is absent, damaged or of another display.
PanelImages LoadPanelImages(const Workspace& workspace, const LayersRecord& record);

}  // namespace lamella
