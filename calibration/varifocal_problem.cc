#include "calibration/varifocal_problem.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>

#include "calibration/free_blocks-inl.h"
#include "calibration/model.h"
#include "calibration/point_residual-inl.h"
#include "calibration/problem-inl.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

// Where a camera sees points that are given in the frame.
template <class T>
struct FrameCamera {
  FrameCamera(const T* camera, const T* rotation, const T* translation, const T* slip)
      : camera_from_frame(RotationOf(rotation)),
        origin(Numbers<T, 3>(translation)),
        lens(Numbers<T, 9>(camera)),
        shift(Numbers<T, 2>(slip)) {}

  model::Vec2<T> Seen(const model::Vec3<T>& frame_point) const {
    const model::Vec3<T> point = camera_from_frame * frame_point + origin;
    if (!(model::ValueOf(point.z()) > 0)) {
      const T nowhere(std::numeric_limits<double>::quiet_NaN());
      return {nowhere, nowhere};
    }
    return model::Project<T>(lens, point) + shift;
  }

  model::Mat3<T> camera_from_frame;
  model::Vec3<T> origin;
  Eigen::Matrix<T, 9, 1> lens;
  model::Vec2<T> shift;
};

// The points of a photograph of which it is known where they are shown: panel px, or mm of the
// frame.
struct ShownPoints {
  struct Point {
    Vector2d shown;
    WhitenedPixel seen;
  };
  const PanelCalibration* panel = nullptr;  // none: marks
  const ceres::LossFunction* loss = nullptr;
  std::vector<Point> points;

  template <class T, class PointOf>
  void SetResiduals(const FrameCamera<T>& camera, const PointOf& point_of, T* residuals) const {
    double lacking = 0;
    for (const Point& point : points) {
      SetResidual<T>(point.seen, camera.Seen(point_of(point.shown)), residuals);
      if (loss != nullptr) lacking += ApplyLoss(*loss, residuals);
      residuals += 2;
    }
    if (loss != nullptr) *residuals = T(std::sqrt(std::max(0.0, lacking)));
  }
};

struct PlaneResidual : ShownPoints {
  template <class T>
  bool operator()(const T* camera, const T* view_rotation, const T* view_translation, const T* slip,
                  const T* plane_rotation, const T* plane_translation, const T* shape,
                  T* residuals) const {
    FrameCamera<T> from(camera, view_rotation, view_translation, slip);
    // Put together once: the plane is this camera's frame.
    from.origin += from.camera_from_frame * Numbers<T, 3>(plane_translation);
    from.camera_from_frame *= RotationOf(plane_rotation);
    const Eigen::Matrix<T, 4, 1> flat_shape = Numbers<T, 4>(shape);
    const auto point_of = [&](const Vector2d& pixel) -> model::Vec3<T> {
      return model::PanelPoint<T, T>(*panel, flat_shape, shape[4], pixel);
    };
    SetResiduals(from, point_of, residuals);
    return true;
  }
};

struct MarkResidual : ShownPoints {
  template <class T>
  bool operator()(const T* camera, const T* view_rotation, const T* view_translation, const T* slip,
                  T* residuals) const {
    const FrameCamera<T> from(camera, view_rotation, view_translation, slip);
    const auto point_of = [](const Vector2d& mm) -> model::Vec3<T> {
      return {T(mm.x()), T(mm.y()), T(0.0)};
    };
    SetResiduals(from, point_of, residuals);
    return true;
  }
};

template <class Residual, int... kBlocks>
std::unique_ptr<ceres::CostFunction> CostOf(ShownPoints points) {
  using Cost = ceres::AutoDiffCostFunction<Residual, ceres::DYNAMIC, kBlocks...>;
  const int num_residuals = 2 * static_cast<int>(points.points.size()) + (points.loss ? 1 : 0);
  return std::make_unique<Cost>(  // which owns the residual
      std::make_unique<Residual>(Residual{std::move(points)}).release(), num_residuals);
}

std::unique_ptr<ceres::CostFunction> MakeCost(ShownPoints points) {
  if (points.panel == nullptr) return CostOf<MarkResidual, 9, 4, 3, 2>(std::move(points));
  return CostOf<PlaneResidual, 9, 4, 3, 2, 4, 3, 5>(std::move(points));
}

// The points of photograph `number` (as PhotosOf counts them) that count.
ShownPoints PointsOf(const std::vector<PanelCalibration>& planes,
                     const VarifocalObservations& observations, std::size_t number,
                     const Weighting& weighting) {
  ShownPoints shown;
  const auto counts = [&](std::size_t i) {
    return weighting.inlier.empty() || weighting.inlier[number][i];
  };
  const auto add = [&](std::size_t i, const Vector2d& at, const auto& sighting) {
    if (counts(i)) shown.points.push_back({at, {sighting.image_px, sighting.covariance_px2}});
  };
  if (number < observations.photos.size()) {
    const PlanePhoto& photo = observations.photos[number];
    shown.panel = &planes[static_cast<std::size_t>(photo.plane)];
    for (std::size_t i = 0; i < photo.points.size(); ++i) {
      add(i, photo.points[i].panel_px, photo.points[i]);
    }
    return shown;
  }
  const auto& marks = observations.views[number - observations.photos.size()].marks;
  for (std::size_t i = 0; i < marks.size(); ++i) add(i, marks[i].frame_mm, marks[i]);
  return shown;
}

std::vector<double*> BlocksOf(VarifocalState& state, const VarifocalObservations& observations,
                              const VarifocalPhoto& photo, std::size_t number) {
  const auto view = static_cast<std::size_t>(photo.view);
  const auto camera = static_cast<std::size_t>(observations.views[view].camera);
  Rigid& pose = state.camera_from_frame[view];
  std::vector<double*> blocks = {state.cameras[camera].data(), pose.rotation.coeffs().data(),
                                 pose.translation.data(), state.slips_px[number].data()};
  if (photo.plane < 0) return blocks;
  PlaneState& plane = state.planes[static_cast<std::size_t>(photo.plane)];
  blocks.insert(blocks.end(), {plane.frame_from_plane.rotation.coeffs().data(),
                               plane.frame_from_plane.translation.data(), plane.shape.data()});
  return blocks;
}

// A state, of which the columns are free, against the points that count.
class VarifocalProblem {
 public:
  VarifocalProblem(VarifocalState& state, const std::vector<PanelCalibration>& planes,
                   const VarifocalColumns& columns, const VarifocalObservations& observations,
                   const Weighting& weighting)
      : state_(state), columns_(columns) {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_ = std::make_unique<ceres::Problem>(options);
    blocks_.emplace(*problem_);
    if (weighting.cauchy > 0) loss_.emplace(weighting.cauchy);
    AddParameters();
    const std::vector<VarifocalPhoto> photos = PhotosOf(observations);
    ceres::LossFunction* loss = loss_ ? &*loss_ : nullptr;
    for (std::size_t i = 0; i < photos.size(); ++i) {
      ShownPoints points = PointsOf(planes, observations, i, weighting);
      points.loss = loss;
      if (!points.points.empty()) {
        problem_->AddResidualBlock(MakeCost(std::move(points)).release(), nullptr,
                                   BlocksOf(state_, observations, photos[i], i));
      }
      if (columns_.common.slip.empty()) continue;
      problem_->AddResidualBlock(MakeSlipPrior(weighting.slip_sd_px).release(), loss,
                                 state_.slips_px[i].data());
    }
  }

  void HoldDisplay() { blocks_->HoldBefore(columns_.common.num_display); }
  ceres::Problem& problem() { return *problem_; }
  NormalEquations Equations() { return blocks_->Equations(columns_.common.size); }

 private:
  void AddParameters() {
    const Columns& common = columns_.common;
    for (std::size_t i = 0; i < state_.cameras.size(); ++i) {
      std::vector<int> columns = ColumnRange(common.camera[i], 9);
      columns.back() = -1;  // k3
      blocks_->AddNumbers(state_.cameras[i].data(), columns);
    }
    for (std::size_t i = 0; i < state_.planes.size(); ++i) AddPlane(i);
    for (std::size_t i = 0; i < state_.camera_from_frame.size(); ++i) {
      AddPose(state_.camera_from_frame[i], common.view[i]);
    }
    for (std::size_t i = 0; i < state_.slips_px.size(); ++i) {
      blocks_->AddNumbers(state_.slips_px[i].data(),
                          ColumnRange(common.slip.empty() ? -1 : common.slip[i], 2));
    }
  }
  void AddPlane(std::size_t i) {
    PlaneState& plane = state_.planes[i];
    const int first = columns_.plane[i];
    AddPose(plane.frame_from_plane, first);
    const auto& [bow, pincushion] = columns_.bent[i];
    blocks_->AddNumbers(plane.shape.data(), {first + 6, -1, -1, bow, pincushion});
  }
  void AddPose(Rigid& pose, int first) {
    blocks_->AddRotation(pose.rotation.coeffs().data(), first);
    blocks_->AddNumbers(pose.translation.data(), ColumnRange(first < 0 ? -1 : first + 3, 3));
  }

  VarifocalState& state_;
  const VarifocalColumns& columns_;
  std::optional<ceres::CauchyLoss> loss_;
  std::unique_ptr<ceres::Problem> problem_;
  std::optional<FreeBlocks> blocks_;
};

}  // namespace

std::vector<Eigen::Matrix2Xd> WhitenedResiduals(const VarifocalState& state,
                                                const std::vector<PanelCalibration>& planes,
                                                const VarifocalObservations& observations) {
  const std::vector<VarifocalPhoto> photos = PhotosOf(observations);
  std::vector<Eigen::Matrix2Xd> residuals(photos.size());
  VarifocalState numbers = state;  // blocks of parameters are not const
  for (std::size_t i = 0; i < photos.size(); ++i) {
    residuals[i].resize(2, static_cast<Eigen::Index>(photos[i].num_points));
    if (photos[i].num_points == 0) continue;
    const auto blocks = BlocksOf(numbers, observations, photos[i], i);
    MakeCost(PointsOf(planes, observations, i, {}))
        ->Evaluate(blocks.data(), residuals[i].data(), nullptr);
  }
  return residuals;
}

NormalEquations Linearise(const VarifocalState& state, const std::vector<PanelCalibration>& planes,
                          const VarifocalColumns& columns,
                          const VarifocalObservations& observations, const Weighting& weighting) {
  Weighting without_loss = weighting;
  without_loss.cauchy = 0;
  VarifocalState numbers = state;
  return VarifocalProblem(numbers, planes, columns, observations, without_loss).Equations();
}

Settling Minimise(const std::vector<PanelCalibration>& planes, const VarifocalColumns& columns,
                  const VarifocalObservations& observations, const Weighting& weighting,
                  const MinimiseOptions& options, VarifocalState& state) {
  VarifocalProblem joint(state, planes, columns, observations, weighting);
  if (options.hold_display) joint.HoldDisplay();
  return MinimiseProblem(joint.problem(), options);
}

}  // namespace lamella
