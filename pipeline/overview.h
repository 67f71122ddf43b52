// preview/overview.jpg: a photograph, its depth, every layer and a simulated eye side by side.
#pragma once

#include "distribute/emitter_strip.h"
#include "distribute/simulate_eye.h"
#include "lightfield/depth_map.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// Panes of one height and at most twice as wide, from the left: `photograph` (linear), `depth` in
// colours (blue far, red near), the layers from back to front as the mean of their slots, cut to
// the picture of `eye`, and what `eye` sees (`seen`, its sRGB codes).
Image<Rgb8> Overview(ImageSpan<const Rgb> photograph, const DepthMap& depth,
                     const OpenEmitters& emitters, const Display& display, const Eye& eye,
                     ImageSpan<const Rgb8> seen);

}  // namespace lamella
