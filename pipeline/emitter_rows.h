// The light of emitters as rows of a picture, from the top to the bottom, for pictures of panels
// that are larger than memory.
#pragma once

#include "depth/resize_area.h"
#include "distribute/emitter_strip.h"
#include "lightfield/display.h"

namespace lamella {

// For ResizeAreaDownwards: rows that rise, the last one again. Of a slot, and what a layer's panel
// shows over a whole frame, the mean of its slots.
RowOf LightRows(const OpenEmitters& open, const Display& display, int layer, int slot);
RowOf MeanRows(const OpenEmitters& open, const Display& display, int layer);

}  // namespace lamella
