// Where a panel lies behind its lens sheet: on the mean over lenses it is seen as if they were not
// there.
#pragma once

#include "calibration/lattice.h"
#include "lightfield/calibration.h"
#include "lightfield/rigid.h"

namespace lamella {

// The design with its emitter moved and turned in its plane so that samples show, on the mean, what
// straight lines of sight would: X = q + f w. Lenses move what is seen by up to half of one either
// way, so that the panel's place is known to a fraction of a lens only, which is what the lattice's
// own equations need of it (f/D times as much). Of panel pixels that are known up to a period, the
// panel is within half of one of its designed place. The design where there are too few samples.
LayerCalibration WithPanelInPlace(const LatticeObservations& observations,
                                  const LayerCalibration& design);

// stack_from_frame, where the cameras are known in another frame: that of a board beside the panel,
// which faces its way. `in_frame` is the sheet's observations as if the sheet lay in that frame's
// plane z = 0. The panel, seen on the mean over the lenses as a flat picture at its reduced gap, is
// put where the design has it. Which decides what is called the display's frame and no more: the
// lines of sight and the lattice turn together, and what a tilt of t leaves is t times the square
// of their slopes, of the gap (1e-4 of it for half a degree and 10 degrees). InputError where the
// panel's picture is none of a plane.
Rigid StackFromFrame(const LatticeObservations& in_frame, const LayerCalibration& design);
// From near it, where panel pixels may be known up to a period.
Rigid StackFromFrame(const LatticeObservations& in_frame, const LayerCalibration& design,
                     const Rigid& near);

}  // namespace lamella
