// The scene `room`: a corner of a room with things at many depths, and photographs of it that a
// person could have taken.
#pragma once

#include <cstdint>

#include "datasets_synthetic/cameras.h"
#include "datasets_synthetic/scene.h"

namespace lamella {

// World: x right, y up, z towards the viewer, metres; the floor is at y = -1, the back wall at
// z = -2.4. Every surface carries texture at all scales, so that features are found everywhere.
Scene Room(std::uint32_t seed);
HandheldArc ArcBeforeRoom();

}  // namespace lamella
