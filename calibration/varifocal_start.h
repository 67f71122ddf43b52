// Starting values of a varifocal display's photographs: from homographies to poses that agree.
#pragma once

#include <string>
#include <vector>

#include "calibration/varifocal_state.h"

namespace lamella {

// Without the photographs of views whose pose is neither given nor told by marks (four or more that
// do not lie near a line): of those nothing is known. Adds a line for each to `left_out`.
// InputError where no view is left: nothing gives lengths then.
VarifocalObservations WithPlacedViews(const VarifocalObservations& observations,
                                      std::vector<std::string>& left_out);

// Cameras as known or without distortion (focal length as given, or from the marks' homographies),
// views as known or from their marks. Planes from the two views whose lines of sight meet on a
// plane that most other views agree with, so that up to 45 % of the points and of a plane's
// photographs may be wrong. InputError naming the plane where it is not seen from two positions, is
// mirrored against its design, or the view whose marks are mirrored.
VarifocalState Initialise(const VarifocalObservations& observations,
                          const std::vector<PanelCalibration>& planes);

// Where a view's marks fit better from the pose that they give with the cameras as they are now:
// that pose. A view that a first guess of the lens left far off is so found again.
void PoseAnew(const VarifocalObservations& observations, VarifocalState& state);

}  // namespace lamella
