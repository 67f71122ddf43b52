// The joint least-squares solution of a varifocal display's photographs, and which of its planes'
// bends they ask for. calibration.md sections 5 and 6.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/select.h"
#include "calibration/uncertainty.h"
#include "calibration/varifocal_problem.h"
#include "calibration/varifocal_state.h"

namespace lamella {

// What is solved: planes as designed, and the photographs.
struct VarifocalTask {
  Calibration design;
  std::vector<PanelCalibration> planes;  // PlanesOf(design)
  VarifocalObservations observations;
};

struct VarifocalFit {
  VarifocalGroups free;
  VarifocalColumns columns;
  VarifocalState state;
  Weighting weighting;        // the points that count, and tau
  NormalEquations equations;  // at the solution, least squares
  double variance = 1;        // chi^2 per degree of freedom of the points that count
  int num_residuals = 0;
  bool converged = false;
  std::vector<std::string> rejected;  // whole photographs, and why
};

// From any start: Cauchy's loss, narrowing to twice the residuals' robust deviation; photographs
// that disagree and points beyond 4 deviations are dropped (inliers.h); least squares; tau from the
// data (slip.h).
VarifocalFit Solve(const VarifocalState& start, const VarifocalTask& task,
                   const VarifocalGroups& free);

// Least squares with the same points and tau but other groups free, from `fit`; what is not free is
// as designed.
VarifocalFit Refit(const VarifocalFit& fit, const VarifocalTask& task, const VarifocalGroups& free);

// Covariance of all columns but the slips, times max(1, chi^2/dof); empty where it has no finite
// value.
Eigen::MatrixXd CovarianceOf(const VarifocalFit& fit);
Degeneracy DegeneracyOf(const VarifocalFit& fit);

// The rigid motion that brings the planes' corners nearest to where they are designed (least
// squares).
Rigid DisplayFromFrame(const VarifocalState& state, const VarifocalTask& task);

struct VarifocalSelection {
  VarifocalFit fit;
  std::vector<GroupVerdict> verdicts;  // pincushion, bow
};

// Poses and magnifications; then pincushion and bow of all planes, each where all hold: chi^2 falls
// by more than q ln N for its q parameters, every direction stays known (degeneracy >= 100), views
// left out (a fourth at a time) are predicted better by 2 standard errors of the mean square, and
// pixels on lines of sight from the eye box change by more than 0.01 px RMS. First what lowers
// chi^2 most. Which points count is found with both free, so that a bend is not taken for errors.
VarifocalSelection SelectGroups(const VarifocalState& start, const VarifocalTask& task,
                                const EyeBox& box);

// Whitened square of every point that counts, each predicted from the other views: cameras and
// planes without a fourth of the views, whose own poses are then fitted.
std::vector<double> HeldOutSquares(const VarifocalFit& fit, const VarifocalTask& task);

}  // namespace lamella
