#include <utility>

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/manifold.h>

#include "calibration/problem-inl.h"

namespace lamella {
namespace {

struct SlipPrior {
  double slip_sd_px;
  template <class T>
  bool operator()(const T* slip, T* residuals) const {
    residuals[0] = slip[0] / slip_sd_px;
    residuals[1] = slip[1] / slip_sd_px;
    return true;
  }
};

// `num` columns from the first; all -1, constant, where that is.
std::vector<int> Range(int first, int num) {
  std::vector<int> columns;
  for (int i = 0; i < num; ++i) columns.push_back(first < 0 ? -1 : first + i);
  return columns;
}

std::vector<Observation> PointsThatCount(const PanelPhoto& photo, std::size_t number,
                                         const Weighting& weighting) {
  if (weighting.inlier.empty()) return photo.points;
  std::vector<Observation> points;
  for (std::size_t i = 0; i < photo.points.size(); ++i) {
    if (weighting.inlier[number][i]) points.push_back(photo.points[i]);
  }
  return points;
}

}  // namespace

std::vector<double*> BlocksOfPhoto(CalibrationState& state, const Structure& structure,
                                   const PanelPhoto& photo, std::size_t number) {
  const auto i = static_cast<std::size_t>(photo.panel.layer);
  const bool emitter = photo.panel.role == PanelId::kEmitter;
  Rigid& view = state.camera_from_world[static_cast<std::size_t>(structure.view_of_photo[number])];
  LayerState& layer = state.layers[i];
  std::vector<double*> blocks = {
      state.cameras[static_cast<std::size_t>(photo.camera)].data(),
      view.rotation.coeffs().data(),
      view.translation.data(),
      layer.world_from_stack.rotation.coeffs().data(),
      layer.world_from_stack.translation.data(),
      emitter ? layer.emitter_shape.data() : layer.modulator_shape.data(),
      state.slips_px[number].data()};
  if (emitter) blocks.insert(blocks.end(), {layer.relation.data(), &layer.index});
  if (structure.design.layers[i].plate) blocks.push_back(&layer.plate_mm);
  return blocks;
}

std::unique_ptr<ceres::CostFunction> MakeSlipPrior(double slip_sd_px) {
  return std::make_unique<ceres::AutoDiffCostFunction<SlipPrior, 2, 2>>(
      std::make_unique<SlipPrior>(SlipPrior{slip_sd_px}).release());
}

JointProblem::JointProblem(const CalibrationState& start, const Structure& structure,
                           const Columns& columns, const Observations& observations,
                           const Weighting& weighting)
    : state_(start), columns_(columns) {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_ = std::make_unique<ceres::Problem>(options);
  if (weighting.cauchy > 0) loss_.emplace(weighting.cauchy);
  AddParameters();
  for (std::size_t i = 0; i < observations.photos.size(); ++i) {
    AddPhoto(structure, observations.photos[i], i, weighting);
  }
}

void JointProblem::AddNumbers(double* values, const std::vector<int>& columns) {
  const int size = static_cast<int>(columns.size());
  std::vector<int> constant, free;
  for (int i = 0; i < size; ++i) {
    const int column = columns[static_cast<std::size_t>(i)];
    if (column < 0) {
      constant.push_back(i);
    } else {
      free.push_back(column);
    }
  }
  problem_->AddParameterBlock(values, size);
  if (free.empty()) return problem_->SetParameterBlockConstant(values);
  if (!constant.empty()) {
    problem_->SetManifold(values,
                          std::make_unique<ceres::SubsetManifold>(size, constant).release());
  }
  free_.push_back({values, free, 1});
}

void JointProblem::AddRotation(double* xyzw, int first_column) {
  problem_->AddParameterBlock(xyzw, 4,
                              std::make_unique<ceres::EigenQuaternionManifold>().release());
  if (first_column < 0) return problem_->SetParameterBlockConstant(xyzw);
  // A step in a quaternion's tangent space is half of the angle.
  free_.push_back({xyzw, Range(first_column, 3), 2});
}

void JointProblem::AddLayer(std::size_t i) {
  LayerState& layer = state_.layers[i];
  const int stack = columns_.stack[i];
  AddRotation(layer.world_from_stack.rotation.coeffs().data(), stack);
  AddNumbers(layer.world_from_stack.translation.data(), Range(stack < 0 ? -1 : stack + 3, 3));
  AddNumbers(layer.relation.data(), Range(columns_.relation[i], 6));
  const auto& emitter = columns_.emitter_shape[i];
  const auto& modulator = columns_.modulator_shape[i];
  AddNumbers(layer.emitter_shape.data(), {emitter.begin(), emitter.end()});
  AddNumbers(layer.modulator_shape.data(), {modulator.begin(), modulator.end()});
  AddNumbers(&layer.index, {columns_.index[i]});
  AddNumbers(&layer.plate_mm, {columns_.plate[i]});
}

void JointProblem::AddParameters() {
  for (std::size_t i = 0; i < state_.cameras.size(); ++i) {
    std::vector<int> columns = Range(columns_.camera[i], 9);
    if (!columns_.k3) columns.back() = -1;
    AddNumbers(state_.cameras[i].data(), columns);
  }
  for (std::size_t i = 0; i < state_.layers.size(); ++i) AddLayer(i);
  for (std::size_t i = 0; i < state_.camera_from_world.size(); ++i) {
    Rigid& view = state_.camera_from_world[i];
    AddRotation(view.rotation.coeffs().data(), columns_.view[i]);
    AddNumbers(view.translation.data(), Range(columns_.view[i] + 3, 3));
  }
  for (std::size_t i = 0; i < state_.slips_px.size(); ++i) {
    AddNumbers(state_.slips_px[i].data(), Range(columns_.slip.empty() ? -1 : columns_.slip[i], 2));
  }
}

void JointProblem::AddPhoto(const Structure& structure, const PanelPhoto& photo, std::size_t number,
                            const Weighting& weighting) {
  ceres::LossFunction* loss = loss_ ? &*loss_ : nullptr;
  const std::vector<Observation> points = PointsThatCount(photo, number, weighting);
  if (!points.empty()) {
    problem_->AddResidualBlock(MakePhotoCost(structure, photo.panel, points, loss).release(),
                               nullptr, BlocksOfPhoto(state_, structure, photo, number));
  }
  if (columns_.slip.empty()) return;
  problem_->AddResidualBlock(MakeSlipPrior(weighting.slip_sd_px).release(), loss,
                             state_.slips_px[number].data());
}

void JointProblem::HoldDisplay() {
  for (const FreeBlock& block : free_) {
    if (block.columns.front() < columns_.num_display) {
      problem_->SetParameterBlockConstant(block.values);
    }
  }
}

NormalEquations JointProblem::Equations() {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  std::vector<int> columns;
  std::vector<double> scales;
  for (const FreeBlock& block : free_) {
    options.parameter_blocks.push_back(block.values);
    columns.insert(columns.end(), block.columns.begin(), block.columns.end());
    scales.insert(scales.end(), block.columns.size(), 1 / block.column_per_tangent);
  }
  double half_cost = 0;
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
  problem_->Evaluate(options, &half_cost, &residuals, nullptr, &jacobian);
  NormalEquations equations;
  equations.cost = 2 * half_cost;
  equations.hessian.setZero(columns_.size, columns_.size);
  equations.gradient.setZero(columns_.size);
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const int begin = jacobian.rows[at(row)], end = jacobian.rows[at(row + 1)];
    for (int i = begin; i < end; ++i) jacobian.values[at(i)] *= scales[at(jacobian.cols[at(i)])];
    for (int i = begin; i < end; ++i) {
      const double slope = jacobian.values[at(i)];
      const int column = columns[at(jacobian.cols[at(i)])];
      equations.gradient(column) += slope * residuals[at(row)];
      for (int j = begin; j < end; ++j) {
        equations.hessian(columns[at(jacobian.cols[at(j)])], column) +=
            slope * jacobian.values[at(j)];
      }
    }
  }
  return equations;
}

}  // namespace lamella
