// Where a panel lies behind its lens sheet: on the mean over lenses it is seen as if they were not
// there.
#pragma once

#include "calibration/lattice.h"
#include "lightfield/calibration.h"

namespace lamella {

// The design with its emitter moved and turned in its plane so that samples show, on the mean, what
// straight lines of sight would: X = q + f w. Lenses move what is seen by up to half of one either
// way, so that the panel's place is known to a fraction of a lens only, which is what the lattice's
// own equations need of it (f/D times as much). Of panel pixels that are known up to a period, the
// panel is within half of one of its designed place. The design where there are too few samples.
LayerCalibration WithPanelInPlace(const LatticeObservations& observations,
                                  const LayerCalibration& design);

}  // namespace lamella
