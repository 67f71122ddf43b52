// The plane sweep's cost, as its header says it: one pixel, one label, one source at a time.
#pragma once

#include "depth/plane_sweep.h"

namespace lamella {

CostVolume SweepPlanesReference(ImageSpan<const std::uint8_t> reference, const Camera& camera,
                                const std::vector<SweepSource>& sources,
                                const InverseDepthRange& range);

}  // namespace lamella
