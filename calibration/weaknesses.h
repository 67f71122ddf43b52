// What a set of photographs does not settle: by name, with the photograph that would.
#pragma once

#include <vector>

#include "calibration/calibrate.h"

namespace lamella {

// Directions of the parameters that stay unknown (eigenvalues of the degeneracy below 100), weakest
// first.
std::vector<Weakness> UnknownDirections(const Fit& fit);

// Photographs whose directions or panels' parts leave the result to extrapolation, though all is
// determined: cameras on one side or on one line, a panel that was seen in part, few views.
std::vector<Weakness> ThinCoverage(const Fit& fit, const Structure& structure,
                                   const Observations& observations, const EyeBox& box);

}  // namespace lamella
