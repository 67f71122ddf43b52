// The lenses of a sheet as a photograph shows them. calibration.md section 3, "Varifocal".
#pragma once

#include <vector>

#include "calibration/observations.h"
#include "calibration/screen_map.h"
#include "lightfield/calibration.h"

namespace lamella {

// Through each lens a camera sees one small part of the panel, the same all over the lens. So the
// panel's point that a photograph's pixel sees tells which lens it is, and the middle of the area
// that shows a lens (lens_shares.h) is where the lens's centre is seen. The photograph must be
// taken from within the lenses' own angles, where emitters are seen through the nearest lens, and
// show a lens with 5 px or more.
//
// Points are the lenses' centres as designed, in the panel's pixels. Of up to 400 lenses each is a
// point; of more, each point is an affine fit (about the homography of all) to the 19 lenses around
// one, and none is part of two, so that points' errors are independent. Covariances are those of
// the lenses' scatter about these fits. Lenses at the rim, without neighbours all around, are left
// out; empty where fewer than 12 are seen whole.
std::vector<Observation> ObserveLenses(const ScreenMap& map, const PanelCalibration& panel,
                                       const LensLattice& lattice);

}  // namespace lamella
