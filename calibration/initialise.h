// Starting values: from one homography per panel and photograph to poses that agree.
#pragma once

#include "calibration/observations.h"
#include "calibration/state.h"

namespace lamella {

// Cameras without distortion, views, stacks and the emitters' places in them; gaps, shapes and
// indices are the design's. Robust to points and whole photographs that are wrong as long as most
// are right: homographies by least median of squares (Rousseeuw 1984), the focal length from them
// where none is given (Zhang 2000), relations as medians over views, and for each view the pose
// that most of its photographs agree with. InputError, with the photograph that is missing, where
// points lie on a line, no camera position joins two panels, or a panel is mirrored against its
// design.
CalibrationState Initialise(const Observations& observations, const Structure& structure);

}  // namespace lamella
