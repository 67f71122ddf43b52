// The preview page's pictures of what the panels show, layer by layer and slot by slot: each panel
// made smaller, since a page has no room for its pixels, and a part pixel by pixel, since slots
// differ by single pixels, which means do not show.
#pragma once

#include <filesystem>

#include "distribute/emitter_strip.h"
#include "lightfield/display.h"
#include "pipeline/report/preview_page.h"

namespace lamella {

// Of the files of a stage frames' folder, codes as sRGB: emitters, modulators, and what the layer
// sends straight ahead over a period; of packed strokes each plane's bit. `shown` is what the
// frames decode to (pipeline/panel_images.h). They are read a file at a time, by every thread.
// InputError where one is absent, damaged or not of the panel's size.
PageSteps StepsOfFrames(const std::filesystem::path& folder, const Display& display,
                        const OpenEmitters& shown);

// Of the emitters' light before it becomes frames.
PageSteps StepsOfLayers(const Display& display, const OpenEmitters& emitters);

}  // namespace lamella
