// Pre-warp: a ready picture for a bare panel, resampled for where the panel really stands
// (calibration.md section 8). For pictures that come from elsewhere; what is made from a capture
// is made for the calibrated panel at once (distribute/distribute.h), and never resampled.
#pragma once

#include <Eigen/Core>

#include "distribute/distribute.h"
#include "lightfield/calibration.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// `picture` has an emitter of the layer as designed in every pixel, from the viewer's side, linear
// light. The result is what the emitters show as calibrated: the picture where the eye at `eye`
// (mm, display's frame) looks through them at the panel as designed, by Catmull-Rom interpolation,
// cut at black; coverage 0 where it looks beside it. Eyes elsewhere see it off its place by
// their distance from `eye` times what the panel is off in depth over the distance to it.
// UsageError where the layer is no bare panel (openings and lenses show another picture to every
// eye) or the eye is not in front of it; InputError where the picture has another size or the
// calibration is of another display.
EmitterImage WarpToPanel(const Image<Rgb>& picture, const Display& display,
                         const Calibration& calibration, int layer, const Eigen::Vector3d& eye);

}  // namespace lamella
