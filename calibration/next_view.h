// The camera position that would help most. calibration.md section 7.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "calibration/solve.h"
#include "calibration/uncertainty.h"

namespace lamella {

// Degrees from the reference panel's normal to the camera, positive to the right and up; mm from
// its middle. What the standard deviation of the ray map would fall from and to were all panels
// photographed from there.
struct NextView {
  double right_deg = 0, up_deg = 0, distance_mm = 0;
  double rms_sd_px = 0, next_rms_sd_px = 0;
};

// Of places up to 30 degrees to the sides and 20 up and down, as far away as the views so far, from
// which all panels fit into the picture. What a builder would assume beforehand (Columns::prior_sd)
// bounds directions of which nothing is known. Nothing where no place fits.
std::optional<NextView> BestNextView(const Fit& fit, const Structure& structure,
                                     const Observations& observations, const EyeBox& box);

}  // namespace lamella
