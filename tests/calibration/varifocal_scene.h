// Photographs of a varifocal display whose planes are known exactly, point by point from plain
// geometry: a panel's pixel to mm, a rigid motion, lightfield/camera.h. The scene is that of
// calibration.md section 3: planes 8.2 mm apart, 12 views within 9 degrees, 80 points, 0.1 px.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calibration/varifocal.h"
#include "lightfield/camera.h"
#include "lightfield/display.h"
#include "lightfield/rigid.h"

namespace lamella {

struct VarifocalSceneOptions {
  int num_planes = 24, num_views = 12;
  double angle_deg = 9;
  int columns = 10, rows = 8;  // points of a plane
  bool known_poses = false, known_camera = true;
  bool sheet = true;                               // its marks are in every view
  int num_sheet_views = 0;                         // of the sheet alone, slanted by 30 degrees
  std::optional<Eigen::Vector3d> further_mm = {};  // a further view of all, from here
  double noise_px = 0.1, slip_px = 0;
  double misalign_mm = 2, misalign_deg = 0.5;  // of all planes together
  double wobble_mm = 0;  // of a plane's depth off the mirror's motion, at most
  double bow_mm = 0, pincushion = 0;
  std::uint32_t seed = 1;
};

struct VarifocalScene {
  struct Plane {
    Rigid display_from_plane;
    double magnification = 1;
  };
  Display display;
  std::vector<Plane> planes;  // the truth
  Rigid display_from_frame;
  Camera camera;
  std::vector<Rigid> camera_from_display;
  VarifocalObservations observations;
};

VarifocalScene MakeVarifocalScene(const VarifocalSceneOptions& options);

// Errors of a calibrated plane, in the display's axes: rotation (rad), position (mm),
// magnification.
PlaneNumbers ErrorsOf(const CalibratedPlane& plane, const VarifocalScene::Plane& truth);

}  // namespace lamella
