// The residuals of a photograph of a panel, with their derivatives by the chain rule. A photograph
// depends on up to 37 numbers, but a point of it only through few: the camera's centre in the
// stack, the panel's place behind it, and the lens. Jets of those are a third of the work of jets
// of all (and the poses, which all points share, are derived once).
#include <algorithm>
#include <cmath>
#include <utility>

#include <ceres/jet.h>

#include "calibration/model.h"
#include "calibration/point_residual-inl.h"
#include "calibration/problem-inl.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The parameter blocks in their order; emitters have relation and index, and the plate's thickness
// is the last.
enum Block { kCamera, kViewRotation, kViewTranslation, kStackRotation, kStackTranslation, kShape };
enum { kSlip = kShape + 1, kRelation, kIndex };
constexpr int kPoseSize = 14;  // of the four blocks of the two poses together

// What a photograph needs of the poses of its view and its stack.
template <class T>
struct Pose {
  model::Mat3<T> camera_from_stack, world_from_stack;
  model::Vec3<T> eye;  // the camera's centre in the stack's frame
};

template <class T>
Pose<T> PoseOf(const T* view_rotation, const T* view_translation, const T* stack_rotation,
               const T* stack_translation) {
  Pose<T> pose;
  const model::Mat3<T> camera_from_world = RotationOf(view_rotation);
  pose.world_from_stack = RotationOf(stack_rotation);
  pose.camera_from_stack = camera_from_world * pose.world_from_stack;
  const model::Vec3<T> from_eye_to_stack =
      camera_from_world.transpose() * Numbers<T, 3>(view_translation) +
      Numbers<T, 3>(stack_translation);
  pose.eye = -(pose.world_from_stack.transpose() * from_eye_to_stack);
  return pose;
}

using PoseSlopes = Eigen::Matrix<double, 3, kPoseSize>;

// The poses and how what follows from them changes with their numbers. A rotation turns by the
// vector that dR R^T is the cross product with: true along Ceres' tangents, which leave a
// quaternion's length alone.
struct PoseWithSlopes {
  Matrix3d camera_from_stack;
  Vector3d eye, normal;                // of the plate, in the stack's frame
  PoseSlopes turn, of_eye, of_normal;  // turn: in the camera's frame
};

PoseWithSlopes DerivePose(double const* const* blocks, const Vector3d& plate_normal) {
  using Jet = ceres::Jet<double, kPoseSize>;
  Jet jets[kPoseSize];
  int next = 0;
  for (const int block : {kViewRotation, kViewTranslation, kStackRotation, kStackTranslation}) {
    const int size = block == kViewRotation || block == kStackRotation ? 4 : 3;
    for (int i = 0; i < size; ++i, ++next) jets[next] = Jet(blocks[block][i], next);
  }
  const Pose<Jet> pose = PoseOf<Jet>(jets, jets + 4, jets + 7, jets + 11);
  const model::Vec3<Jet> normal = pose.world_from_stack.transpose() * plate_normal.cast<Jet>();
  PoseWithSlopes derived;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) derived.camera_from_stack(i, j) = pose.camera_from_stack(i, j).a;
    derived.eye(i) = pose.eye(i).a;
    derived.of_eye.row(i) = pose.eye(i).v.transpose();
    derived.normal(i) = normal(i).a;
    derived.of_normal.row(i) = normal(i).v.transpose();
  }
  for (int k = 0; k < kPoseSize; ++k) {
    Matrix3d slope;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) slope(i, j) = pose.camera_from_stack(i, j).v(k);
    }
    const Matrix3d cross = slope * derived.camera_from_stack.transpose();
    derived.turn.col(k) << (cross(2, 1) - cross(1, 2)) / 2, (cross(0, 2) - cross(2, 0)) / 2,
        (cross(1, 0) - cross(0, 1)) / 2;
  }
  return derived;
}

// What all points of one photograph share, and the points.
struct PhotoPoints {
  struct Point {
    Vector2d panel_px;
    WhitenedPixel image;
  };
  const PanelCalibration* panel = nullptr;
  double plate_index = 1;
  Vector3d plate_normal{0, 0, 1};  // in the world
  const ceres::LossFunction* loss = nullptr;
  std::vector<Point> points;
};

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

template <bool kEmitter, bool kPlate>
class PhotoCost final : public ceres::CostFunction {
 public:
  explicit PhotoCost(PhotoPoints photo) : photo_(std::move(photo)) {
    std::vector<int>& sizes = *mutable_parameter_block_sizes();
    sizes = {model::kCameraSize, 4, 3, 4, 3, 4, 2};
    if (kEmitter) sizes.insert(sizes.end(), {6, 1});
    if (kPlate) sizes.push_back(1);
    set_num_residuals(2 * static_cast<int>(photo_.points.size()) + (photo_.loss ? 1 : 0));
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    double lacking = 0;
    if (jacobians == nullptr) {
      EvaluateResiduals(blocks, residuals, lacking);
    } else {
      EvaluateSlopes(blocks, residuals, jacobians, lacking);
    }
    if (photo_.loss != nullptr) {
      residuals[num_residuals() - 1] = std::sqrt(std::max(0.0, lacking));
    }
    return true;
  }

 private:
  // The numbers that the direction to a point follows from, in their order: the eye and what the
  // blocks of shape, relation, index and plate hold, then the plate's normal.
  static constexpr int kAtShape = 3, kAtRelation = 7, kAtIndex = 13, kAtPlate = kEmitter ? 14 : 7,
                       kLocal = kAtPlate + (kPlate ? 4 : 0);
  static constexpr int kPlateBlock = kEmitter ? kIndex + 1 : kSlip + 1;
  using Local = Eigen::Matrix<double, kLocal, 1>;

  Local LocalNumbers(double const* const* blocks, const Vector3d& eye,
                     const Vector3d& normal) const {
    Local numbers;
    numbers.template head<3>() = eye;
    numbers.template segment<4>(kAtShape) = Numbers<double, 4>(blocks[kShape]);
    if constexpr (kEmitter) {
      numbers.template segment<6>(kAtRelation) = Numbers<double, 6>(blocks[kRelation]);
      numbers(kAtIndex) = *blocks[kIndex];
    }
    if constexpr (kPlate) {
      numbers(kAtPlate) = *blocks[kPlateBlock];
      numbers.template tail<3>() = normal;
    }
    return numbers;
  }

  template <class T>
  model::PhotoModel<T> ModelOf(const Eigen::Matrix<T, kLocal, 1>& local) const {
    model::PhotoModel<T> m;
    m.panel = photo_.panel;
    m.eye = local.template head<3>();
    m.shape = local.template segment<4>(kAtShape);
    if constexpr (kEmitter) {
      const T* relation = local.data() + kAtRelation;
      m.emitter = true;
      m.stack_from_emitter = model::Rotation<T>(Numbers<T, 3>(relation + 3));
      m.emitter_origin << relation[0], relation[1], -relation[2];
      m.index = local(kAtIndex);
    }
    if constexpr (kPlate) {
      m.has_plate = true;
      m.plate.thickness_mm = local(kAtPlate);
      m.plate.index = photo_.plate_index;
      m.plate.normal = local.template tail<3>();
    }
    return m;
  }

  // False where the panel is seen from behind, or the point lies behind the camera.
  static bool IsSeen(const Vector3d& eye, const Vector3d& seen) {
    return seen.z() > 0 && eye.z() > 0;
  }

  void EvaluateResiduals(double const* const* blocks, double* residuals, double& lacking) const {
    const Pose<double> pose = PoseOf<double>(blocks[kViewRotation], blocks[kViewTranslation],
                                             blocks[kStackRotation], blocks[kStackTranslation]);
    const model::PhotoModel<double> m = ModelOf<double>(
        LocalNumbers(blocks, pose.eye, pose.world_from_stack.transpose() * photo_.plate_normal));
    const auto camera = Numbers<double, model::kCameraSize>(blocks[kCamera]);
    for (const PhotoPoints::Point& point : photo_.points) {
      const Vector3d seen = pose.camera_from_stack * model::DirectionTo(m, point.panel_px);
      Vector2d residual(kUnseenResidual, 0);
      if (IsSeen(pose.eye, seen)) {
        const Vector2d pixel =
            model::Project<double>(camera, seen) + Numbers<double, 2>(blocks[kSlip]);
        if (Usable<double>(pixel))
          residual = point.image.whitening * (pixel - point.image.image_px);
      }
      residual *= ScaleOfLoss(photo_.loss, residual, lacking);
      *residuals++ = residual.x();
      *residuals++ = residual.y();
    }
  }

  void EvaluateSlopes(double const* const* blocks, double* residuals, double** jacobians,
                      double& lacking) const {
    using Jet = ceres::Jet<double, kLocal>;
    const PoseWithSlopes pose = DerivePose(blocks, photo_.plate_normal);
    const Local numbers = LocalNumbers(blocks, pose.eye, pose.normal);
    Eigen::Matrix<Jet, kLocal, 1> local;
    for (int i = 0; i < kLocal; ++i) local(i) = Jet(numbers(i), i);
    const model::PhotoModel<Jet> m = ModelOf<Jet>(local);
    ClearSlopes(jacobians);
    for (std::size_t i = 0; i < photo_.points.size(); ++i) {
      const PhotoPoints::Point& point = photo_.points[i];
      const model::Vec3<Jet> direction = model::DirectionTo(m, point.panel_px);
      Vector3d towards;
      Eigen::Matrix<double, 3, kLocal> of_local;
      for (int k = 0; k < 3; ++k) {
        towards(k) = direction(k).a;
        of_local.row(k) = direction(k).v.transpose();
      }
      const Vector3d seen = pose.camera_from_stack * towards;
      Vector2d residual(kUnseenResidual, 0);
      LensSlopes lens;
      bool usable = IsSeen(pose.eye, seen);
      if (usable) {
        const Vector2d pixel =
            ProjectWithSlopes(blocks[kCamera], seen, lens) + Numbers<double, 2>(blocks[kSlip]);
        usable = Usable<double>(pixel);
        if (usable) residual = point.image.whitening * (pixel - point.image.image_px);
      }
      const double scale = ScaleOfLoss(photo_.loss, residual, lacking);
      residual *= scale;
      residuals[2 * i] = residual.x();
      residuals[2 * i + 1] = residual.y();
      if (!usable) continue;
      const Eigen::Matrix2d whitening = scale * point.image.whitening;
      lens = (whitening * lens).eval();
      const Eigen::Matrix<double, 2, 3> of_seen = lens.rightCols<3>();
      const Eigen::Matrix<double, 2, kLocal> slopes = (of_seen * pose.camera_from_stack) * of_local;
      Eigen::Matrix<double, 2, kPoseSize> of_pose =
          -(of_seen * CrossMatrix(seen)) * pose.turn + slopes.template leftCols<3>() * pose.of_eye;
      if constexpr (kPlate) of_pose += slopes.template rightCols<3>() * pose.of_normal;
      SetSlopes(i, lens, of_pose, slopes, whitening, jacobians);
    }
  }

  using LensSlopes = Eigen::Matrix<double, 2, model::kCameraSize + 3>;  // camera, then seen

  static Vector2d ProjectWithSlopes(const double* camera, const Vector3d& seen,
                                    LensSlopes& slopes) {
    constexpr int kSize = model::kCameraSize;
    using Jet = ceres::Jet<double, kSize + 3>;
    Eigen::Matrix<Jet, kSize, 1> parameters;
    for (int i = 0; i < kSize; ++i) parameters(i) = Jet(camera[i], i);
    const model::Vec3<Jet> point(Jet(seen.x(), kSize), Jet(seen.y(), kSize + 1),
                                 Jet(seen.z(), kSize + 2));
    const model::Vec2<Jet> pixel = model::Project<Jet>(parameters, point);
    slopes << pixel.x().v.transpose(), pixel.y().v.transpose();
    return {pixel.x().a, pixel.y().a};
  }

  void ClearSlopes(double** jacobians) const {
    for (std::size_t block = 0; block < parameter_block_sizes().size(); ++block) {
      if (jacobians[block] == nullptr) continue;
      std::fill_n(jacobians[block], num_residuals() * parameter_block_sizes()[block], 0.0);
    }
  }

  // The two rows of a point in every block that is asked for.
  template <class LocalSlopes>
  void SetSlopes(std::size_t point, const LensSlopes& lens,
                 const Eigen::Matrix<double, 2, kPoseSize>& of_pose, const LocalSlopes& slopes,
                 const Eigen::Matrix2d& of_slip, double** jacobians) const {
    const auto set = [&](int block, const auto& rows) {
      if (jacobians[block] == nullptr) return;
      double* to = jacobians[block] + 2 * point * static_cast<std::size_t>(rows.cols());
      for (Eigen::Index r = 0; r < 2; ++r) {
        for (Eigen::Index c = 0; c < rows.cols(); ++c) *to++ = rows(r, c);
      }
    };
    set(kCamera, lens.template leftCols<model::kCameraSize>());
    set(kViewRotation, of_pose.template leftCols<4>());
    set(kViewTranslation, of_pose.template middleCols<3>(4));
    set(kStackRotation, of_pose.template middleCols<4>(7));
    set(kStackTranslation, of_pose.template rightCols<3>());
    set(kShape, slopes.template middleCols<4>(kAtShape));
    set(kSlip, of_slip);
    if constexpr (kEmitter) {
      set(kRelation, slopes.template middleCols<6>(kAtRelation));
      set(kIndex, slopes.template middleCols<1>(kAtIndex));
    }
    if constexpr (kPlate) set(kPlateBlock, slopes.template middleCols<1>(kAtPlate));
  }

  PhotoPoints photo_;
};

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
    if (plate) return std::make_unique<PhotoCost<true, true>>(std::move(photo));
    return std::make_unique<PhotoCost<true, false>>(std::move(photo));
  }
  if (plate) return std::make_unique<PhotoCost<false, true>>(std::move(photo));
  return std::make_unique<PhotoCost<false, false>>(std::move(photo));
}

}  // namespace lamella
