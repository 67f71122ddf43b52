#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <ceres/autodiff_cost_function.h>

#include "calibration/model.h"
#include "calibration/point_residual-inl.h"
#include "calibration/problem-inl.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// What all points of one photograph share, and the points.
struct PhotoPoints {
  struct Point {
    Vector2d panel_px;
    WhitenedPixel seen;
  };
  const PanelCalibration* panel = nullptr;
  double plate_index = 1;
  Vector3d plate_normal{0, 0, 1};  // in the world
  const ceres::LossFunction* loss = nullptr;
  std::vector<Point> points;
};

// Emitters have a relation to their stack and an index before them, and some photographs are taken
// through a plate. The others are spared these derivatives; up to 36 in all Eigen unrolls a Jet's
// loops, which takes half the time.
template <bool kEmitter, bool kPlate>
struct PhotoResidual : PhotoPoints {
  // `rest` is relation and index of emitters, the plate's thickness where there is one, residuals.
  template <class T, class... Rest>
  bool operator()(const T* camera, const T* view_rotation, const T* view_translation,
                  const T* stack_rotation, const T* stack_translation, const T* shape,
                  const T* slip, Rest... rest) const {
    const std::tuple<Rest...> others(rest...);
    model::PhotoModel<T> m;
    m.panel = panel;
    m.camera = Numbers<T, 9>(camera);
    m.slip = Numbers<T, 2>(slip);
    m.shape = Numbers<T, 4>(shape);
    const model::Mat3<T> camera_from_world = RotationOf(view_rotation);
    const model::Mat3<T> world_from_stack = RotationOf(stack_rotation);
    m.camera_from_stack = camera_from_world * world_from_stack;
    const model::Vec3<T> from_eye_to_stack =
        camera_from_world.transpose() * Numbers<T, 3>(view_translation) +
        Numbers<T, 3>(stack_translation);
    m.eye = -(world_from_stack.transpose() * from_eye_to_stack);
    if constexpr (kEmitter) {
      const T* relation = std::get<0>(others);
      m.emitter = true;
      m.stack_from_emitter = model::Rotation<T>(Numbers<T, 3>(relation + 3));
      m.emitter_origin << relation[0], relation[1], -relation[2];
      m.index = *std::get<1>(others);
    }
    if constexpr (kPlate) {
      m.has_plate = true;
      m.plate.thickness_mm = *std::get<sizeof...(Rest) - 2>(others);
      m.plate.index = plate_index;
      m.plate.normal = world_from_stack.transpose() * plate_normal.cast<T>();
    }
    T* residuals = std::get<sizeof...(Rest) - 1>(others);
    double lacking = 0;
    for (const Point& point : points) {
      SetResidual<T>(point.seen, model::Photographed<T>(m, point.panel_px), residuals);
      if (loss != nullptr) lacking += ApplyLoss(*loss, residuals);
      residuals += 2;
    }
    if (loss != nullptr) *residuals = T(std::sqrt(std::max(0.0, lacking)));
    return true;
  }
};

// Sizes of the blocks that all photographs have, then of those that only some have.
template <bool kEmitter, bool kPlate, int... kMore>
std::unique_ptr<ceres::CostFunction> PhotoCost(PhotoPoints points) {
  using Residual = PhotoResidual<kEmitter, kPlate>;
  using Cost = ceres::AutoDiffCostFunction<Residual, ceres::DYNAMIC, 9, 4, 3, 4, 3, 4, 2, kMore...>;
  const int num_residuals = 2 * static_cast<int>(points.points.size()) + (points.loss ? 1 : 0);
  return std::make_unique<Cost>(  // which owns the residual
      std::make_unique<Residual>(Residual{std::move(points)}).release(), num_residuals);
}

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

std::unique_ptr<ceres::CostFunction> MakePhotoCost(const Structure& structure, const PanelId& panel,
                                                   const std::vector<Observation>& points,
                                                   const ceres::LossFunction* loss) {
  const std::vector<LayerCalibration>& layers = structure.design.layers;
  const std::optional<Plate>& plate = layers[static_cast<std::size_t>(panel.layer)].plate;
  PhotoPoints photo;
  photo.panel = &structure.Panel(panel);
  photo.loss = loss;
  if (plate) {
    const Rigid& display_from_world =
        layers[static_cast<std::size_t>(structure.reference.layer)].display_from_stack;
    photo.plate_index = plate->index;
    photo.plate_normal = display_from_world.rotation.inverse() * plate->normal;
  }
  for (const Observation& point : points) {
    photo.points.push_back({point.panel_px, {point.image_px, point.covariance_px2}});
  }
  if (panel.role == PanelId::kEmitter) {
    return plate ? PhotoCost<true, true, 6, 1, 1>(std::move(photo))
                 : PhotoCost<true, false, 6, 1>(std::move(photo));
  }
  return plate ? PhotoCost<false, true, 1>(std::move(photo))
               : PhotoCost<false, false>(std::move(photo));
}

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
