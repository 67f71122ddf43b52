// A calibrated lens sheet in the numbers of a Looking Glass display's visual.json (calibration.md
// section 10).
#pragma once

#include <string>

#include "lightfield/calibration.h"
#include "lightfield/looking_glass.h"

namespace lamella {

struct SheetForViewer {
  LookingGlass panel;
  double view_cone_deg = 0;  // full angle that all views span, in air
};

// Of a striped panel behind slanted cylinder lenses, for a viewer at a distance from the lenses:
// their pitch as seen on the panel from there, p' = p (1 + f/D), their lean against the panel's
// rows, and the phase with which a viewer on the axis sees the middle view, one who stands x
// further right across the lenses 1/2 + x f/(D p'). What the numbers cannot say is left out: bow,
// skew, unequal sides, refraction beyond its first order. InputError naming `where` if the layer is
// no such sheet, its lenses stand upright (visual.json has no slope for that) or it is seen in a
// mirror.
SheetForViewer SheetFor(const LayerCalibration& layer, double distance_mm,
                        const std::string& where);

}  // namespace lamella
