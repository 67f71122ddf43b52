// The frame of a layer's emissive panel in one time slot, whatever the layer's optics. Final:
// emitters are spread over their pixels, mirrored and encoded, and nothing is resampled.
#pragma once

#include "distribute/distribute.h"
#include "distribute/panel_response.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// As wide as the panel; of all rows of emitters or some. Emitters without coverage (unknown ones,
// and guard pixels, which have no ray) are black. A lenticular's channels stay in their pixel: they
// are the stripes that it stands on, and a panel seen by reflection has them in reverse. Not
// darkened by the number of layers: the optics that superpose them do that. `first_row` is that of
// the emitters given.
Image<Rgb8> EmitterFrame(const EmitterImage& emitters, const Display& display, int layer,
                         const PanelResponse& response, int first_row = 0);

}  // namespace lamella
