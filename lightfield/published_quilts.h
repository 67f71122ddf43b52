// The quilts that Looking Glass's players expect of each of its devices (displays.md section 4).
#pragma once

#include <string_view>

#include "lightfield/looking_glass.h"

namespace lamella {

struct PublishedQuilt {
  int columns = 0, rows = 0;
  int width_px = 0, height_px = 0;  // of the whole
};

// By the letters after "LKG-" of a device's serial. Of a serial that tells no device: that of the
// Portrait for upright panels, else that of the 16 inch one.
PublishedQuilt PublishedQuiltFor(std::string_view serial, bool upright);

// The Portrait's numbers as they are published: what a screen is like of which no calibration is
// given. Every device has its own, so nothing is woven by these.
LookingGlass NominalPortrait();
constexpr double kNominalConeDeg = 40;

}  // namespace lamella
