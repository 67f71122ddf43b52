// The panels' emissive frames of W/frames, decoded by rows to the light that their emitters
// emit.
#pragma once

#include "distribute/emitter_strip.h"
#include "pipeline/layers_record.h"
#include "pipeline/workspace.h"

namespace lamella {

struct PanelImages {
  OpenEmitters open;
  bool grey = false;  // the display has no colours
};

// As the display shows them: 8-bit codes through the panels' response, or the mean of one-bit
// strokes, which are counted before; mirrored panels turned back. The coverage is that of the
// layers. Refers to both. InputError where frames.json or a frame is absent, damaged or of another
// display.
PanelImages OpenPanelImages(const Workspace& workspace, const LayersRecord& record);

}  // namespace lamella
