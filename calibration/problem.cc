#include <utility>

#include <ceres/autodiff_cost_function.h>

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
  free_.emplace(*problem_);
  if (weighting.cauchy > 0) loss_.emplace(weighting.cauchy);
  AddParameters();
  for (std::size_t i = 0; i < observations.photos.size(); ++i) {
    AddPhoto(structure, observations.photos[i], i, weighting);
  }
}

void JointProblem::AddLayer(std::size_t i) {
  LayerState& layer = state_.layers[i];
  const int stack = columns_.stack[i];
  free_->AddRotation(layer.world_from_stack.rotation.coeffs().data(), stack);
  free_->AddNumbers(layer.world_from_stack.translation.data(),
                    ColumnRange(stack < 0 ? -1 : stack + 3, 3));
  free_->AddNumbers(layer.relation.data(), ColumnRange(columns_.relation[i], 6));
  const auto& emitter = columns_.emitter_shape[i];
  const auto& modulator = columns_.modulator_shape[i];
  free_->AddNumbers(layer.emitter_shape.data(), {emitter.begin(), emitter.end()});
  free_->AddNumbers(layer.modulator_shape.data(), {modulator.begin(), modulator.end()});
  free_->AddNumbers(&layer.index, {columns_.index[i]});
  free_->AddNumbers(&layer.plate_mm, {columns_.plate[i]});
}

void JointProblem::AddParameters() {
  for (std::size_t i = 0; i < state_.cameras.size(); ++i) {
    std::vector<int> columns = ColumnRange(columns_.camera[i], 9);
    if (!columns_.k3) columns.back() = -1;
    free_->AddNumbers(state_.cameras[i].data(), columns);
  }
  for (std::size_t i = 0; i < state_.layers.size(); ++i) AddLayer(i);
  for (std::size_t i = 0; i < state_.camera_from_world.size(); ++i) {
    Rigid& view = state_.camera_from_world[i];
    free_->AddRotation(view.rotation.coeffs().data(), columns_.view[i]);
    free_->AddNumbers(view.translation.data(), ColumnRange(columns_.view[i] + 3, 3));
  }
  for (std::size_t i = 0; i < state_.slips_px.size(); ++i) {
    free_->AddNumbers(state_.slips_px[i].data(),
                      ColumnRange(columns_.slip.empty() ? -1 : columns_.slip[i], 2));
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

void JointProblem::HoldDisplay() { free_->HoldBefore(columns_.num_display); }

NormalEquations JointProblem::Equations() { return free_->Equations(columns_.size); }

}  // namespace lamella
