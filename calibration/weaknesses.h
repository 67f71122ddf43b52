// What a set of photographs does not settle: by name, with the photograph that would.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/calibrate.h"

namespace lamella {

// Directions of the parameters that stay unknown (eigenvalues of the degeneracy below 100), weakest
// first.
std::vector<Weakness> UnknownDirections(const Fit& fit);

// Photographs whose directions or panels' parts leave the result to extrapolation, though all is
// determined: cameras on one side or on one line, a panel that was seen in part, few views. The
// maps are those of the panels (MapResiduals).
std::vector<Weakness> ThinCoverage(const Fit& fit, const Structure& structure,
                                   const std::vector<ResidualMap>& maps, const EyeBox& box);
// Where a panel was seen in less than 60 % of its cells; `leaning` is what is extrapolated then.
std::optional<Weakness> SeenInPart(const std::string& name, const ResidualMap& map,
                                   const std::string& leaning = "its rotation and tilt are");

}  // namespace lamella
