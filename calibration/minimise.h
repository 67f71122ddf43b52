// The joint problem minimised from a state, by Ceres.
#pragma once

#include <string>

#include "calibration/observations.h"
#include "calibration/residuals.h"
#include "calibration/state.h"

namespace ceres {
class Problem;
}

namespace lamella {

std::string SolverVersion();  // "Ceres 2.1.0"

struct MinimiseOptions {
  int max_iterations = 40;  // what is determined takes 20 at most
  double damping = 1e-4;    // of the first step, relative to the Hessian's diagonal
  double smallest_gain = 1e-14;
  bool hold_display = false;  // cameras and layers as they are: only views and slips are free
};
struct Minimum {
  CalibrationState state;
  int iterations = 0;
  bool converged = false;
};

// Levenberg-Marquardt until a step lowers the cost (chi^2, or its loss) by less than
// smallest_gain, or by nothing that rounding leaves visible. On one thread, so that sums have one
// order. From the problem's numbers, in place:
struct Settling {
  int iterations = 0;
  bool converged = false;
};
Settling MinimiseProblem(ceres::Problem& problem, const MinimiseOptions& options);
// From `state`:
Minimum Minimise(const CalibrationState& state, const Structure& structure, const Columns& columns,
                 const Observations& observations, const Weighting& weighting,
                 const MinimiseOptions& options = {});

}  // namespace lamella
