// Whether a solution's numbers may be believed: what its residuals say against it. calibration.md
// section 7.
#pragma once

#include <vector>

#include "calibration/calibrate.h"

namespace lamella {

// Fails, each with the photograph that would cure it:
//   photographs of one position shift against one another by more than 0.05 px (tau)
//   a panel's or a view's chi^2 per degree of freedom, relative to that of all points (a view's:
//     of its panels' points), is not between 0.7 and 1.5
//   a cell of a panel's residual map has a mean of more than 0.03 px, or lost more than 35 % of its
//     points: the model lacks something there
//   views that are left out fit worse than 1.3 times the RMS of the fit, both in deviations
// Bounds are wider by four standard deviations of what chance does to so many points.
std::vector<Weakness> Contradictions(const Fit& fit, const Structure& structure,
                                     const Observations& observations);

}  // namespace lamella
