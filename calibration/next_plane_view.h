// The camera position that would help a varifocal display's planes most. calibration.md section 7,
// by what they are asked to be known to.
#pragma once

#include <optional>

#include "calibration/varifocal_solve.h"
#include "lightfield/rigid.h"

namespace lamella {

// What depth and magnification of every plane must be known to, as standard deviations.
struct PlaneLimits {
  double depth_sd_mm = 0, magnification_sd = 0;
};

// Degrees from the display's normal to the camera, positive to the right and up; mm from the
// planes' middle. What the worst known plane would be known to were all planes, and the sheet,
// photographed from there; `times_limit` is the larger of the two in what is asked for, now and
// then.
struct NextPlaneView {
  double right_deg = 0, up_deg = 0, distance_mm = 0;
  double times_limit = 0, next_times_limit = 0;
  double next_depth_sd_mm = 0, next_magnification_sd = 0;
};

// Of places within the angles of the lenses (30 degrees where there are none), as far away as the
// views so far, from which all planes fit into the picture. Of poses that are known beforehand the
// next one is, too. What a builder would assume (Columns::prior_sd) bounds what is not known at
// all. Nothing where no place fits.
std::optional<NextPlaneView> BestNextPlaneView(const VarifocalFit& fit, const VarifocalTask& task,
                                               const Rigid& display_from_frame,
                                               const PlaneLimits& limits);

}  // namespace lamella
