// Which groups of parameters the photographs ask for and carry. calibration.md section 6.
#pragma once

#include <string>
#include <vector>

#include "calibration/solve.h"
#include "calibration/uncertainty.h"

namespace lamella {

// One group that was tried: whether it was freed, and why or why not.
struct GroupVerdict {
  std::string group;  // "bow"
  bool freed = false;
  std::string reason;
  double chi2_fall = 0, chi2_needed = 0;  // Bayesian information criterion
  double degeneracy = 0;                  // with the group free (uncertainty.h)
  double heldout_gain = 0;                // of the mean square, in standard errors
  double benefit_px = 0;                  // RMS change of the ray map
};

struct Selection {
  Fit fit;
  std::vector<GroupVerdict> verdicts;  // in the order in which they were tried
};

// From starting values (initialise.h): the base model, then tries thickness of a plate (where the
// design has one), bow, scale, aspect and skew, k3, index; first what would lower chi^2 most (Rao's
// score test, which also spares the solution with what is not asked for). A group is freed where
// all hold:
//   chi^2 falls by more than q ln N for its q parameters (variance of the larger model)
//   every direction of all parameters stays known (degeneracy >= 100; an index to 0.05)
//   views left out (a fourth at a time) are predicted better by 2 standard errors of the mean
//   square the ray map changes by more than 0.01 px RMS
// What was refused is tried again when another group was freed, and what is freed is taken back
// when later groups make it superfluous.
Selection SelectGroups(const CalibrationState& start, const Structure& structure,
                       const Observations& observations, const EyeBox& box);

}  // namespace lamella
