#include "tests/calibration/varifocal_scene.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "tests/calibration/degree.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSpacingMm = 8.2, kPitchMm = 0.1631;
constexpr int kWidthPx = 1024, kHeightPx = 768;

Display DisplayOf(const VarifocalSceneOptions& options) {
  Display display;
  display.name = "varifocal";
  display.width_px = kWidthPx;
  display.height_px = kHeightPx;
  display.pitch_mm = kPitchMm;
  display.viewing_distance_mm = 500;
  display.varifocal = Varifocal{};
  display.varifocal->planes = options.num_planes;
  display.varifocal->depth_mm = kSpacingMm * (options.num_planes - 1);
  Layer layer;
  layer.d0_mm = 2.92;
  layer.optics = LensletArray{};
  display.layers = PlanesOf(*display.varifocal, layer);
  return display;
}

struct Dice {
  std::mt19937 random;
  double Even() { return std::uniform_real_distribution<double>(-1, 1)(random); }
  double Normal() { return std::normal_distribution<double>()(random); }
  Vector2d Normal2(double sd) {
    const double x = sd * Normal(), y = sd * Normal();
    return {x, y};
  }
  Vector3d Even3(double most) {
    const double x = most * Even(), y = most * Even(), z = most * Even();
    return {x, y, z};
  }
};

Eigen::Quaterniond Turned(const Vector3d& by) {
  return by.isZero(0) ? Eigen::Quaterniond::Identity()
                      : Eigen::Quaterniond(Eigen::AngleAxisd(by.norm(), by.normalized()));
}

// A misaligned relay with a focal length of 400 mm: all planes shift, turn and lean along the
// mirror's path.
std::vector<VarifocalScene::Plane> Planes(const VarifocalSceneOptions& options, Dice& dice) {
  const Vector3d shift = dice.Even3(options.misalign_mm);
  const Vector3d turn = dice.Even3(options.misalign_deg * kDegree);
  const Vector3d lean = dice.Even3(0.01), turn_along = dice.Even3(2e-5);
  std::vector<VarifocalScene::Plane> planes;
  for (int k = 0; k < options.num_planes; ++k) {
    const double z = kSpacingMm * (k - (options.num_planes - 1) / 2.0);
    VarifocalScene::Plane plane;
    plane.display_from_plane.rotation = Turned(turn + z * turn_along);
    plane.display_from_plane.translation =
        shift + Vector3d(z * lean.x(), z * lean.y(), z * (1 + lean.z()));
    plane.magnification = 1.01 + plane.display_from_plane.translation.z() / 400;
    plane.display_from_plane.translation.z() += options.wobble_mm * dice.Even();
    planes.push_back(plane);
  }
  return planes;
}

Vector3d Around(double yaw, double pitch, double distance) {
  return distance * Vector3d(std::sin(yaw) * std::cos(pitch), std::sin(pitch),
                             std::cos(yaw) * std::cos(pitch));
}

// A camera that looks at the display's middle.
Rigid LookingAtPlanes(const Vector3d& from, double roll) {
  const Vector3d forward = -from.normalized();
  const Vector3d right = forward.cross(Vector3d(0, 1, 0)).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  rotation = Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix() * rotation;
  return {Eigen::Quaterniond(rotation), -(rotation * from)};
}

// Two rings, then the sheet's own views, then a further one.
std::vector<Rigid> Views(const VarifocalSceneOptions& options) {
  std::vector<Rigid> views;
  const int all = options.num_views + options.num_sheet_views;
  for (int i = 0; i < all; ++i) {
    const bool sheet_only = i >= options.num_views;
    const double around = 2 * std::numbers::pi * i / options.num_views + 0.3;
    const double angle = sheet_only ? 30 : options.angle_deg * (i % 2 == 0 ? 1 : 1.0 / 3);
    const double distance = 1050 + 130 * std::cos(2.4 * i);
    views.push_back(LookingAtPlanes(
        Around(angle * std::cos(around) * kDegree, angle * std::sin(around) * kDegree, distance),
        90 * (i % 3) * kDegree));
  }
  if (options.further_mm) views.push_back(LookingAtPlanes(*options.further_mm, 0));
  return views;
}

Camera Photographer() {
  Camera camera;
  camera.model = CameraModel::kBrown;
  camera.width = 5472;
  camera.height = 3648;
  camera.fx = 7000;
  camera.fy = 7010;
  camera.cx = 2741;
  camera.cy = 1815;
  camera.distortion = {-0.08, 0.05, 3e-4, -2e-4, 0};
  return camera;
}

Vector3d PointOf(const VarifocalScene::Plane& plane, const Vector2d& pixel,
                 const VarifocalSceneOptions& options) {
  const double half = kPitchMm / 2 * std::hypot(kWidthPx, kHeightPx);
  Vector2d at(pixel.x() - kWidthPx / 2.0, kHeightPx / 2.0 - pixel.y());
  at *= kPitchMm * plane.magnification;
  at *= 1 + options.pincushion * at.squaredNorm() / (half * half);
  return plane.display_from_plane *
         Vector3d(at.x(), at.y(), options.bow_mm * at.squaredNorm() / (half * half));
}

// Of an A3 sheet: corners of squares of 15 mm above, below and beside the planes.
std::vector<Vector2d> Marks() {
  std::vector<Vector2d> marks;
  for (int row = 0; row < 19; ++row) {
    for (int column = 0; column < 27; ++column) {
      const Vector2d at(15.0 * (column - 13), 15.0 * (row - 9));
      if (std::abs(at.x()) < 95 && std::abs(at.y()) < 75) continue;
      marks.push_back(at);
    }
  }
  return marks;
}

void AddPlanePhotos(const VarifocalSceneOptions& options, int view, VarifocalScene& scene,
                    Dice& dice) {
  const Rigid& pose = scene.camera_from_display[static_cast<std::size_t>(view)];
  for (int k = 0; k < options.num_planes; ++k) {
    PlanePhoto photo{k, view, "plane" + std::to_string(k) + "_view" + std::to_string(view), {}};
    const Vector2d slip = dice.Normal2(options.slip_px);
    for (int i = 0; i < options.columns * options.rows; ++i) {
      const int row = i / options.columns, column = i % options.columns;
      const Vector2d pixel((column + 0.5) * kWidthPx / options.columns,
                           (row + 0.5) * kHeightPx / options.rows);
      const auto seen = Project(
          scene.camera, pose * PointOf(scene.planes[static_cast<std::size_t>(k)], pixel, options));
      if (!seen) continue;
      photo.points.push_back({pixel, *seen + slip + dice.Normal2(options.noise_px),
                              options.noise_px * options.noise_px * Eigen::Matrix2d::Identity()});
    }
    scene.observations.photos.push_back(photo);
  }
}

void AddView(const VarifocalSceneOptions& options, int view, VarifocalScene& scene, Dice& dice) {
  const Rigid& pose = scene.camera_from_display[static_cast<std::size_t>(view)];
  const Rigid camera_from_frame = pose * scene.display_from_frame;
  VarifocalView added{std::to_string(view), 0, {}, std::nullopt};
  if (options.known_poses) added.camera_from_frame = camera_from_frame;
  const Vector2d slip = dice.Normal2(options.slip_px);
  for (const Vector2d& mark : Marks()) {
    if (!options.sheet) break;
    const auto seen = Project(scene.camera, camera_from_frame * Vector3d(mark.x(), mark.y(), 0));
    if (!seen) continue;
    added.marks.push_back({mark, *seen + slip + dice.Normal2(options.noise_px),
                           options.noise_px * options.noise_px * Eigen::Matrix2d::Identity()});
  }
  scene.observations.views.push_back(added);
  const bool sheet_only =
      view >= options.num_views && view < options.num_views + options.num_sheet_views;
  if (!sheet_only) AddPlanePhotos(options, view, scene, dice);
}

}  // namespace

VarifocalScene MakeVarifocalScene(const VarifocalSceneOptions& options) {
  Dice dice{std::mt19937(options.seed)};
  VarifocalScene scene;
  scene.display = DisplayOf(options);
  scene.planes = Planes(options, dice);
  scene.display_from_frame = {Turned({0.02, -0.01, 0.03}), {4, -3, -60}};
  scene.camera = Photographer();
  scene.camera_from_display = Views(options);
  VarifocalCamera body{"body", scene.camera.width, scene.camera.height, 6900, std::nullopt};
  if (options.known_camera) body.known = scene.camera;
  scene.observations.cameras = {body};
  const int all = static_cast<int>(scene.camera_from_display.size());
  for (int view = 0; view < all; ++view) AddView(options, view, scene, dice);
  return scene;
}

PlaneNumbers ErrorsOf(const CalibratedPlane& plane, const VarifocalScene::Plane& truth) {
  const Eigen::AngleAxisd turn(plane.display_from_plane.rotation *
                               truth.display_from_plane.rotation.inverse());
  PlaneNumbers errors;
  errors << turn.angle() * turn.axis(),
      plane.display_from_plane.translation - truth.display_from_plane.translation,
      plane.magnification - truth.magnification;
  return errors;
}

}  // namespace lamella
