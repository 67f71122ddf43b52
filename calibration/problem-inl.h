// The least-squares problem of all photographs as Ceres takes it. Include it in .cc files only, as
// all of Ceres.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include "calibration/observations.h"
#include "calibration/residuals.h"
#include "calibration/state.h"

namespace lamella {

// Residuals L^T (predicted - measured) of points of one photograph, 2 each, with derivatives by
// ceres::Jet. Its parameter blocks: camera 9, view's rotation 4 (x, y, z, w) and translation 3,
// stack's rotation 4 and translation 3, relation 6, panel's shape 4, index 1, plate's thickness 1,
// slip 2. Relation and index leave a modulator where it is. `structure` must outlive it.
constexpr std::size_t kNumPhotoBlocks = 10;
std::unique_ptr<ceres::CostFunction> MakePhotoCost(const Structure& structure,
                                                   const PanelPhoto& photo,
                                                   std::vector<Observation> points);
// These blocks of a state, in that order.
std::array<double*, kNumPhotoBlocks> BlocksOfPhoto(CalibrationState& state,
                                                   const Structure& structure,
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
  // Of least squares, whatever the loss.
  NormalEquations Equations();

 private:
  // A block with the columns of its tangent space and how far one unit of it goes in a column.
  struct FreeBlock {
    double* values;
    std::vector<int> columns;
    double column_per_tangent;
  };

  void AddNumbers(double* values, const std::vector<int>& columns);
  void AddRotation(double* xyzw, int first_column);
  void AddLayer(std::size_t layer);
  void AddParameters();
  void AddPhoto(const Structure& structure, const PanelPhoto& photo, std::size_t number,
                const Weighting& weighting);

  CalibrationState state_;
  const Columns& columns_;
  std::optional<ceres::CauchyLoss> loss_;
  std::vector<FreeBlock> free_;
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace lamella
