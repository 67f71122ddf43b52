// The joint least-squares solution of all photographs. calibration.md section 5.
#pragma once

#include <string>
#include <vector>

#include "calibration/observations.h"
#include "calibration/residuals.h"
#include "calibration/state.h"

namespace lamella {

struct Fit {
  FreeGroups free;
  Columns columns;
  CalibrationState state;
  Weighting weighting;        // the points that count, and tau
  NormalEquations equations;  // at the solution, least squares
  double variance = 1;        // chi^2 per degree of freedom of the points that count
  int num_residuals = 0;
  int iterations = 0;
  bool converged = false;
  std::vector<std::string> rejected;  // "NAME (layer 1 emitter): why" of whole photographs
};

// From any start: Cauchy's loss, narrowing to twice the residuals' robust deviation; whole
// photographs that disagree and points beyond 4 deviations are dropped; least squares; tau
// from the data (slip.h).
Fit Solve(const CalibrationState& start, const Structure& structure,
          const Observations& observations, const FreeGroups& free);

// From near the solution, with all points: drops what disagrees, then least squares with tau from
// the data, until the points stay the same.
void Settle(const Structure& structure, const Observations& observations, Fit& fit);

// Least squares with the same points and tau but other groups free, from `fit`.
Fit Refit(const Fit& fit, const Structure& structure, const Observations& observations,
          const FreeGroups& free);

}  // namespace lamella
