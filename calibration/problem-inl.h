// The least-squares problem of all photographs as Ceres takes it. Include it in .cc files only, as
// all of Ceres.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include "calibration/free_blocks-inl.h"
#include "calibration/observations.h"
#include "calibration/residuals.h"
#include "calibration/state.h"

namespace lamella {

// Residuals L^T (predicted - measured) of points of one photograph of a panel, 2 each, with exact
// derivatives. With a loss, of each point, they are scaled so that the gradient is
// the loss's, and one more without a slope follows, so that the sum of squares is the sum of
// losses. One block for a photograph rather than for a point is faster: poses are put together
// once, and Ceres has fewer blocks to arrange. `structure` and the loss must outlive it.
std::unique_ptr<ceres::CostFunction> MakePhotoCost(const Structure& structure, const PanelId& panel,
                                                   const std::vector<Observation>& points,
                                                   const ceres::LossFunction* loss = nullptr);
// Its parameter blocks in a state: camera 9, view's rotation 4 (x, y, z, w) and translation 3,
// stack's rotation 4 and translation 3, panel's shape 4, slip 2; of emitters relation 6, index 1;
// where there is a plate its thickness.
std::vector<double*> BlocksOfPhoto(CalibrationState& state, const Structure& structure,
                                   const PanelPhoto& photo, std::size_t number);

// slip / tau.
std::unique_ptr<ceres::CostFunction> MakeSlipPrior(double slip_sd_px);

// A state, of which the columns are free, against the points that count. All references must
// outlive it.
class JointProblem {
 public:
  JointProblem(const CalibrationState& start, const Structure& structure, const Columns& columns,
               const Observations& observations, const Weighting& weighting);
  JointProblem(const JointProblem&) = delete;  // Ceres holds addresses of the state's numbers
  JointProblem& operator=(const JointProblem&) = delete;

  // Keeps cameras and layers as they are: views and slips stay free.
  void HoldDisplay();
  ceres::Problem& problem() { return *problem_; }
  const CalibrationState& state() const { return state_; }
  // At the state. For a problem without a loss.
  NormalEquations Equations();

 private:
  void AddLayer(std::size_t i);
  void AddParameters();
  void AddPhoto(const Structure& structure, const PanelPhoto& photo, std::size_t number,
                const Weighting& weighting);

  CalibrationState state_;
  const Columns& columns_;
  std::optional<ceres::CauchyLoss> loss_;
  std::unique_ptr<ceres::Problem> problem_;
  std::optional<FreeBlocks> free_;
};

}  // namespace lamella
