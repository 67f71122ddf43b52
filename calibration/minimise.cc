#include "calibration/minimise.h"

#include <ceres/iteration_callback.h>
#include <ceres/solver.h>
#include <ceres/version.h>

#include "calibration/problem-inl.h"

namespace lamella {
namespace {

// Ceres compares what a step gains with the whole cost; what counts here is the gain itself, the
// square of the step in standard deviations.
class StopAtSmallGain : public ceres::IterationCallback {
 public:
  explicit StopAtSmallGain(double smallest) : smallest_(smallest) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const bool stepped = summary.iteration > 0 && summary.step_is_successful;
    return stepped && 2 * summary.cost_change < smallest_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                          : ceres::SOLVER_CONTINUE;
  }

 private:
  double smallest_;
};

}  // namespace

std::string SolverVersion() { return "Ceres " CERES_VERSION_STRING; }

Settling MinimiseProblem(ceres::Problem& problem, const MinimiseOptions& options) {
  StopAtSmallGain stop(options.smallest_gain);
  ceres::Solver::Options how;
  how.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  how.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  how.max_num_iterations = options.max_iterations;
  how.initial_trust_region_radius = 1 / options.damping;
  how.function_tolerance = 1e-16;
  how.gradient_tolerance = 0;
  how.parameter_tolerance = 1e-15;
  how.num_threads = 1;
  how.logging_type = ceres::SILENT;
  how.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(how, &problem, &summary);
  return {summary.num_successful_steps + summary.num_unsuccessful_steps - 1,
          summary.termination_type == ceres::CONVERGENCE ||
              summary.termination_type == ceres::USER_SUCCESS};
}

Minimum Minimise(const CalibrationState& state, const Structure& structure, const Columns& columns,
                 const Observations& observations, const Weighting& weighting,
                 const MinimiseOptions& options) {
  JointProblem joint(state, structure, columns, observations, weighting);
  if (options.hold_display) joint.HoldDisplay();
  const Settling settling = MinimiseProblem(joint.problem(), options);
  return {joint.state(), settling.iterations, settling.converged};
}

}  // namespace lamella
