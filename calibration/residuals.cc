#include "calibration/residuals.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "calibration/model.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Where a photograph's parameters stand among the columns of its Jacobian.
enum Place {
  kCamera = 0,
  kView = 9,
  kStack = 15,
  kRelation = 21,
  kShape = 27,
  kIndex = 31,
  kPlate = 32,
  kSlip = 33
};
using D = Dual<kPhotoColumns>;
using Map = std::array<int, kPhotoColumns>;

// A parameter as a number, or as a dual that knows its column.
template <class T>
T Parameter(double value, int column);
template <>
double Parameter<double>(double value, int) {
  return value;
}
template <>
D Parameter<D>(double value, int column) {
  return D::Variable(value, column);
}

// A rotation whose tangent turns it from the left by 3 parameters.
template <class T>
model::Mat3<T> TurnedRotation(const Eigen::Quaterniond& rotation, int column) {
  const model::Vec3<T> turn(Parameter<T>(0, column), Parameter<T>(0, column + 1),
                            Parameter<T>(0, column + 2));
  model::Mat3<T> cross;
  cross << T(1.0), -turn.z(), turn.y(), turn.z(), T(1.0), -turn.x(), -turn.y(), turn.x(), T(1.0);
  return cross * rotation.toRotationMatrix().cast<T>();
}

template <class T, int N>
Eigen::Matrix<T, N, 1> Parameters(const Eigen::Matrix<double, N, 1>& values, int column) {
  Eigen::Matrix<T, N, 1> out;
  for (int i = 0; i < N; ++i) out(i) = Parameter<T>(values(i), column + i);
  return out;
}

template <class T>
model::PhotoModel<T> ModelOf(const CalibrationState& state, const Structure& structure,
                             const PanelPhoto& photo, std::size_t number) {
  const auto view = static_cast<std::size_t>(structure.view_of_photo[number]);
  const auto i = static_cast<std::size_t>(photo.panel.layer);
  const LayerState& layer = state.layers[i];
  const LayerCalibration& design = structure.design.layers[i];
  model::PhotoModel<T> m;
  m.panel = &structure.Panel(photo.panel);
  m.camera = Parameters<T, 9>(state.cameras[static_cast<std::size_t>(photo.camera)], kCamera);
  m.slip = Parameters<T, 2>(state.slips_px[number], kSlip);
  const Rigid& pose = state.camera_from_world[view];
  const model::Mat3<T> camera_from_world = TurnedRotation<T>(pose.rotation, kView);
  const model::Mat3<T> world_from_stack =
      TurnedRotation<T>(layer.world_from_stack.rotation, kStack);
  m.camera_from_stack = camera_from_world * world_from_stack;
  const model::Vec3<T> camera_t = Parameters<T, 3>(pose.translation, kView + 3);
  const model::Vec3<T> stack_t = Parameters<T, 3>(layer.world_from_stack.translation, kStack + 3);
  const model::Vec3<T> in_world = camera_from_world.transpose() * camera_t + stack_t;
  m.eye = -(world_from_stack.transpose() * in_world);
  m.emitter = photo.panel.role == PanelId::kEmitter;
  m.shape = Parameters<T, 4>(m.emitter ? layer.emitter_shape : layer.modulator_shape, kShape);
  if (m.emitter) {
    const Eigen::Matrix<T, 6, 1> r = Parameters<T, 6>(layer.relation, kRelation);
    m.stack_from_emitter = model::Rotation<T>(r.template tail<3>());
    m.emitter_origin << r(0), r(1), -r(2);
    m.index = Parameter<T>(layer.index, kIndex);
  }
  if (design.plate) {
    m.has_plate = true;
    m.plate.thickness_mm = Parameter<T>(layer.plate_mm, kPlate);
    m.plate.index = design.plate->index;
    const auto reference = static_cast<std::size_t>(structure.reference.layer);
    const Vector3d normal =
        structure.design.layers[reference].display_from_stack.rotation.inverse() *
        design.plate->normal;
    m.plate.normal = world_from_stack.transpose() * normal.cast<T>();
  }
  return m;
}

// Global columns of a photograph's own, -1 where constant.
Map MapOf(const Structure& structure, const Columns& columns, const PanelPhoto& photo,
          std::size_t number) {
  Map map;
  map.fill(-1);
  const auto put = [&](int place, int first, int num) {
    for (int i = 0; first >= 0 && i < num; ++i) {
      map[static_cast<std::size_t>(place + i)] = first + i;
    }
  };
  const auto i = static_cast<std::size_t>(photo.panel.layer);
  const bool emitter = photo.panel.role == PanelId::kEmitter;
  put(kCamera, columns.camera[static_cast<std::size_t>(photo.camera)], columns.k3 ? 9 : 8);
  put(kView, columns.view[static_cast<std::size_t>(structure.view_of_photo[number])], 6);
  put(kStack, columns.stack[i], 6);
  const auto& shape = emitter ? columns.emitter_shape[i] : columns.modulator_shape[i];
  for (std::size_t k = 0; k < 4; ++k) map[kShape + k] = shape[k];
  put(kPlate, columns.plate[i], 1);
  if (!columns.slip.empty()) put(kSlip, columns.slip[number], 2);
  if (!emitter) return map;
  put(kRelation, columns.relation[i], 6);
  put(kIndex, columns.index[i], 1);
  return map;
}

// L^T with L L^T the covariance's inverse.
Eigen::Matrix2d Whitening(const Observation& point) {
  const Eigen::Matrix2d information = point.covariance_px2.inverse();
  return information.llt().matrixU();
}

// Of a point that its camera can't see: far beyond any outlier, without a slope.
constexpr double kUnseen = 1e6;

bool Usable(const Vector2d& pixel) {
  return pixel.allFinite() && pixel.cwiseAbs().maxCoeff() < 1e8;
}

bool Counts(const Weighting& weighting, std::size_t photo, std::size_t point) {
  return weighting.inlier.empty() || weighting.inlier[photo][point];
}

double Loss(double squared, double width) {
  return width > 0 ? width * width * std::log1p(squared / (width * width)) : squared;
}

double LossSlope(double squared, double width) {
  return width > 0 ? 1 / (1 + squared / (width * width)) : 1;
}

// One photograph's share of the normal equations, in its own columns.
struct Share {
  Eigen::Matrix<double, kPhotoColumns, kPhotoColumns> hessian;
  Eigen::Matrix<double, kPhotoColumns, 1> gradient;
  double cost = 0;
};

Share ShareOf(const CalibrationState& state, const Structure& structure, const PanelPhoto& photo,
              std::size_t number, const Weighting& weighting) {
  const model::PhotoModel<D> m = ModelOf<D>(state, structure, photo, number);
  const auto num = static_cast<Eigen::Index>(photo.points.size());
  Eigen::Matrix<double, kPhotoColumns, Eigen::Dynamic> transposed(kPhotoColumns, 2 * num);
  Eigen::VectorXd residuals(2 * num);
  transposed.setZero();
  residuals.setZero();
  Share share;
  for (std::size_t i = 0; i < photo.points.size(); ++i) {
    if (!Counts(weighting, number, i)) continue;
    const Observation& point = photo.points[i];
    const model::Vec2<D> predicted = model::Photographed<D>(m, point.panel_px);
    const Vector2d pixel(predicted.x().value, predicted.y().value);
    if (!Usable(pixel)) {
      share.cost += Loss(kUnseen * kUnseen, weighting.cauchy);
      continue;
    }
    const Eigen::Matrix2d whitening = Whitening(point);
    const Vector2d r = whitening * (pixel - point.image_px);
    const double squared = r.squaredNorm();
    const double weight = std::sqrt(LossSlope(squared, weighting.cauchy));
    share.cost += Loss(squared, weighting.cauchy);
    const auto at = 2 * static_cast<Eigen::Index>(i);
    residuals.segment<2>(at) = weight * r;
    const Eigen::Matrix2d w = weight * whitening;
    transposed.col(at) = (w(0, 0) * predicted.x().d + w(0, 1) * predicted.y().d).matrix();
    transposed.col(at + 1) = (w(1, 0) * predicted.x().d + w(1, 1) * predicted.y().d).matrix();
  }
  share.hessian.setZero();
  share.hessian.selfadjointView<Eigen::Lower>().rankUpdate(transposed);
  share.hessian.triangularView<Eigen::StrictlyUpper>() = share.hessian.transpose();
  share.gradient = transposed * residuals;
  return share;
}

void Scatter(const Share& share, const Map& map, NormalEquations& equations) {
  equations.cost += share.cost;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] < 0) continue;
    equations.gradient(map[i]) += share.gradient(static_cast<int>(i));
    for (std::size_t j = 0; j < map.size(); ++j) {
      if (map[j] < 0) continue;
      equations.hessian(map[i], map[j]) += share.hessian(static_cast<int>(i), static_cast<int>(j));
    }
  }
}

// d/tau of every photograph that has a point left.
void AddSlipPriors(const CalibrationState& state, const Columns& columns,
                   const Weighting& weighting, NormalEquations& equations) {
  for (std::size_t i = 0; i < columns.slip.size(); ++i) {
    const Vector2d r = state.slips_px[i] / weighting.slip_sd_px;
    const double squared = r.squaredNorm(), weight = LossSlope(squared, weighting.cauchy);
    equations.cost += Loss(squared, weighting.cauchy);
    for (int k = 0; k < 2; ++k) {
      const int at = columns.slip[i] + k;
      equations.hessian(at, at) += weight / (weighting.slip_sd_px * weighting.slip_sd_px);
      equations.gradient(at) += weight * r(k) / weighting.slip_sd_px;
    }
  }
}

}  // namespace

NormalEquations Linearise(const CalibrationState& state, const Structure& structure,
                          const Columns& columns, const Observations& observations,
                          const Weighting& weighting) {
  const std::size_t num = observations.photos.size();
  std::vector<Share> shares(num);
  ParallelForEach(0, static_cast<std::int64_t>(num), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    shares[at] = ShareOf(state, structure, observations.photos[at], at, weighting);
  });
  NormalEquations equations;
  equations.hessian.setZero(columns.size, columns.size);
  equations.gradient.setZero(columns.size);
  for (std::size_t i = 0; i < num; ++i) {
    Scatter(shares[i], MapOf(structure, columns, observations.photos[i], i), equations);
  }
  AddSlipPriors(state, columns, weighting, equations);
  return equations;
}

std::vector<Eigen::Matrix2Xd> WhitenedResiduals(const CalibrationState& state,
                                                const Structure& structure,
                                                const Observations& observations) {
  std::vector<Eigen::Matrix2Xd> residuals(observations.photos.size());
  ParallelForEach(0, static_cast<std::int64_t>(residuals.size()), [&](std::int64_t number) {
    const auto at = static_cast<std::size_t>(number);
    const PanelPhoto& photo = observations.photos[at];
    const auto m = ModelOf<double>(state, structure, photo, at);
    residuals[at].resize(2, static_cast<Eigen::Index>(photo.points.size()));
    for (std::size_t i = 0; i < photo.points.size(); ++i) {
      const Observation& point = photo.points[i];
      const Vector2d pixel = model::Photographed<double>(m, point.panel_px);
      Vector2d r(kUnseen, 0);
      if (Usable(pixel)) r = Whitening(point) * (pixel - point.image_px);
      residuals[at].col(static_cast<Eigen::Index>(i)) = r;
    }
  });
  return residuals;
}

double Cost(const CalibrationState& state, const Structure& structure,
            const Observations& observations, const Columns& columns, const Weighting& weighting) {
  const auto residuals = WhitenedResiduals(state, structure, observations);
  double cost = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    double photo = 0;
    for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
      if (!Counts(weighting, i, static_cast<std::size_t>(k))) continue;
      photo += Loss(residuals[i].col(k).squaredNorm(), weighting.cauchy);
    }
    cost += photo;
  }
  for (std::size_t i = 0; i < columns.slip.size(); ++i) {
    cost += Loss((state.slips_px[i] / weighting.slip_sd_px).squaredNorm(), weighting.cauchy);
  }
  return cost;
}

std::vector<Prediction> Predict(const CalibrationState& state, const Structure& structure,
                                const Observations& observations, std::size_t photo) {
  const PanelPhoto& of = observations.photos[photo];
  const auto m = ModelOf<D>(state, structure, of, photo);
  std::vector<Prediction> predictions;
  for (const Observation& point : of.points) {
    const model::Vec2<D> pixel = model::Photographed<D>(m, point.panel_px);
    Prediction prediction;
    prediction.image_px << pixel.x().value, pixel.y().value;
    prediction.jacobian.row(0) = pixel.x().d.matrix().transpose();
    prediction.jacobian.row(1) = pixel.y().d.matrix().transpose();
    predictions.push_back(prediction);
  }
  return predictions;
}

}  // namespace lamella
