#include "tests/calibration/standard_scene.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "lightfield/panel_rays.h"
#include "tests/calibration/degree.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

PanelCalibration Panel(bool mirrored) {
  PanelCalibration panel;
  panel.width_px = 1920;
  panel.height_px = 1080;
  panel.pitch_mm = 0.31125;
  panel.mirror_x = mirrored;
  return panel;
}

LayerCalibration Stack(double z_mm, bool mirrored, const SceneOptions& options) {
  LayerCalibration layer;
  layer.display_from_stack.translation = {0, 0, z_mm};
  layer.emitter = Panel(mirrored);
  layer.modulator = Panel(mirrored);
  layer.gap_mm = options.gap_mm;
  layer.index = options.index;
  return layer;
}

Calibration Misaligned(const Calibration& design, const SceneOptions& options) {
  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&](double scale) {
    const double x = number(random), y = number(random), z = number(random);
    return Vector3d(scale * x, scale * y, scale * z);
  };
  Calibration truth = design;
  for (std::size_t i = 0; i < truth.layers.size(); ++i) {
    LayerCalibration& layer = truth.layers[i];
    layer.rotation_rad = vector(options.misalign_deg * kDegree);
    // Tilted by more, the emitter would pierce its modulator.
    layer.rotation_rad.head<2>() = vector(0.3 * options.gap_mm / 300).head<2>();
    layer.offset_mm = vector(options.misalign_mm).head<2>();
    layer.gap_mm *= 1 + 0.1 * number(random);
    layer.emitter.scale = options.scale * number(random);
    layer.emitter.bow_mm = options.bow_mm;
    layer.modulator->bow_mm = options.bow_mm;
    const Vector3d turn = vector(options.misalign_deg * kDegree);
    const Vector3d shift = vector(options.misalign_mm);
    const double scale = options.scale * number(random);
    if (layer.plate) layer.plate->thickness_mm = options.plate_mm;
    if (i + 1 == truth.layers.size()) continue;  // the reference
    layer.modulator->scale = scale;
    layer.display_from_stack.translation += shift;
    layer.display_from_stack.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  }
  return truth;
}

// A camera that looks at the display's middle from yaw and pitch, rolled.
Rigid LookingAt(double yaw, double pitch, double roll, double distance) {
  const Vector3d from = distance * Vector3d(std::sin(yaw) * std::cos(pitch), std::sin(pitch),
                                            std::cos(yaw) * std::cos(pitch));
  const Vector3d forward = -from.normalized();
  const Vector3d right = forward.cross(Vector3d(0, 1, 0)).normalized();
  const Vector3d down = forward.cross(right);
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), down.transpose(), forward.transpose();
  rotation = Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix() * rotation;
  return {Eigen::Quaterniond(rotation), -(rotation * from)};
}

std::vector<Rigid> Views(const SceneOptions& options) {
  std::vector<Rigid> views;
  for (int i = 0; i < options.num_views; ++i) {
    const double turn = 2 * std::numbers::pi * i / options.num_views + 0.3;
    const double ring = i % 2 == 0 ? 1 : 1.0 / 3;  // two rings
    const double part =
        options.num_views > 1 ? static_cast<double>(i) / (options.num_views - 1) : 0;
    const double distance = options.near_mm + (options.far_mm - options.near_mm) *
                                                  (0.5 + 0.5 * std::cos(2.4 * 6 * part));
    const double yaw = ring * options.yaw_deg * std::cos(turn) + options.one_side_deg;
    const double pitch = ring * options.pitch_deg * std::sin(turn);
    const double roll = options.rolls ? 90.0 * (i % 3) : 0;
    views.push_back(LookingAt(yaw * kDegree, pitch * kDegree, roll * kDegree, distance));
  }
  return views;
}

Camera Photographer(const SceneOptions& options) {
  Camera camera;
  camera.model = CameraModel::kBrown;
  camera.width = 5472;
  camera.height = 3648;
  camera.fx = 7000;
  camera.fy = 7010;
  camera.cx = 2741;
  camera.cy = 1815;
  camera.distortion = {-0.08, 0.05, 3e-4, -2e-4, options.k3};
  return camera;
}

PanelPhoto PhotoOf(const StandardScene& scene, PanelId panel, int view,
                   const SceneOptions& options) {
  PanelPhoto photo{panel, view, 0, "", {}};
  photo.photo = "view" + std::to_string(view) + "_" + std::to_string(panel.layer) +
                (panel.role == PanelId::kEmitter ? "em" : "mod") + ".png";
  const LayerCalibration& layer = scene.truth.layers[static_cast<std::size_t>(panel.layer)];
  const double square_u = 1920.0 / (options.columns + 1), square_v = 1080.0 / (options.rows + 1.5);
  for (int row = 0; row < options.rows; ++row) {
    for (int column = 0; column < options.columns; ++column) {
      const Vector2d pixel(square_u * (column + 1), square_v * (row + 1.25));
      const auto at = SeenAt(layer, panel.role, scene.camera,
                             scene.camera_from_display[static_cast<std::size_t>(view)], pixel);
      if (!at) continue;
      photo.points.push_back({pixel, *at, 0.01 * Eigen::Matrix2d::Identity()});
    }
  }
  return photo;
}

}  // namespace

std::optional<Vector2d> SeenAt(const LayerCalibration& layer, PanelId::Role role,
                               const Camera& camera, const Rigid& camera_from_display,
                               const Vector2d& panel_px) {
  const LayerSights sights(layer);
  const Vector3d eye = Centre(camera_from_display);
  const auto panel_at = [&](const Vector2d& image_px) -> std::optional<Vector2d> {
    const auto direction = Unproject(camera, image_px);
    if (!direction) return std::nullopt;
    const auto hit = sights.Seen(eye, camera_from_display.rotation.inverse() * *direction);
    if (!hit) return std::nullopt;
    return role == PanelId::kEmitter ? hit->emitter : hit->modulator;
  };
  const PanelCalibration& panel = role == PanelId::kEmitter ? layer.emitter : *layer.modulator;
  Vector3d point = PanelPoint(panel, panel_px);
  if (role == PanelId::kEmitter) point = StackFromEmitter(layer) * point;
  const auto start = Project(camera, camera_from_display * (layer.display_from_stack * point));
  if (!start) return std::nullopt;
  Vector2d at = *start;
  for (int i = 0; i < 8; ++i) {  // Newton's method with differences
    const auto here = panel_at(at);
    const auto right = panel_at(at + Vector2d(0.01, 0)), below = panel_at(at + Vector2d(0, 0.01));
    if (!here || !right || !below) return std::nullopt;
    Eigen::Matrix2d slope;
    slope << (*right - *here) / 0.01, (*below - *here) / 0.01;
    const Vector2d step = slope.inverse() * (panel_px - *here);
    at += step;
    if (step.norm() < 1e-10) break;
  }
  const bool inside =
      at.x() > 8 && at.y() > 8 && at.x() < camera.width - 8 && at.y() < camera.height - 8;
  if (!inside) return std::nullopt;
  return at;
}

StandardScene MakeStandardScene(const SceneOptions& options) {
  StandardScene scene;
  scene.design.display = "standard";
  scene.design.layers = {Stack(-80, true, options), Stack(0, false, options)};
  if (options.plate_mm > 0 || options.design_plate_mm > 0) {
    const double slant = 45 * kDegree;
    scene.design.layers[0].plate =
        Plate{options.design_plate_mm, 1.52, {std::sin(slant), 0, std::cos(slant)}};
  }
  scene.truth = Misaligned(scene.design, options);
  scene.camera = Photographer(options);
  scene.camera_from_display = Views(options);
  scene.exact.cameras = {{"body", scene.camera.width, scene.camera.height, 6900}};
  for (int view = 0; view < options.num_views; ++view) {
    for (const PanelId panel : {PanelId{1, PanelId::kModulator}, PanelId{1, PanelId::kEmitter},
                                PanelId{0, PanelId::kModulator}, PanelId{0, PanelId::kEmitter}}) {
      scene.exact.photos.push_back(PhotoOf(scene, panel, view, options));
    }
  }
  return scene;
}

Observations Noisy(const Observations& exact, double sd_px, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sd_px);
  Observations noisy = exact;
  for (PanelPhoto& photo : noisy.photos) {
    for (Observation& point : photo.points) {
      point.image_px.x() += normal(random);
      point.image_px.y() += normal(random);
      point.covariance_px2 = sd_px * sd_px * Eigen::Matrix2d::Identity();
    }
  }
  return noisy;
}

void AddSlips(Observations& observations, double sd_px, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sd_px);
  for (PanelPhoto& photo : observations.photos) {
    const double x = normal(random), y = normal(random);
    for (Observation& point : photo.points) point.image_px += Vector2d(x, y);
  }
}

}  // namespace lamella
