// Photographs of a display whose panels are known exactly, made along lines of sight from the
// camera to the panels (lightfield/panel_rays.h): the opposite direction to the code under test,
// which goes from the panels to the photographs. The scene is that of calibration.md: two stacks of
// two panels, the one at the back seen in a mirror.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/observations.h"
#include "lightfield/calibration.h"
#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

struct SceneOptions {
  int num_views = 12;
  double yaw_deg = 20, pitch_deg = 12;
  double near_mm = 920, far_mm = 1180;
  bool rolls = true;
  double one_side_deg = 0;  // added to every yaw
  double gap_mm = 5, index = 1.49;
  double misalign_mm = 2, misalign_deg = 0.5;  // of display and panels against the design, at most
  double scale = 0;                            // of the panels but the reference, at most
  double bow_mm = 0;                           // of every panel
  double plate_mm = 0;                         // before the layer at the back
  double design_plate_mm = 0;                  // what the datasheet says
  int columns = 23, rows = 12;                 // corners of the pattern
  double k3 = 0;
  std::uint32_t seed = 1;
};

struct StandardScene {
  Calibration truth, design;
  Camera camera;
  std::vector<Rigid> camera_from_display;  // of each view
  Observations exact;                      // covariance 0.01 px^2: that of 0.1 px noise
};

StandardScene MakeStandardScene(const SceneOptions& options);

// Where the camera sees a panel's pixel, if it does.
std::optional<Eigen::Vector2d> SeenAt(const LayerCalibration& layer, PanelId::Role role,
                                      const Camera& camera, const Rigid& camera_from_display,
                                      const Eigen::Vector2d& panel_px);

// The same with Gaussian noise of every coordinate, its covariance stated.
Observations Noisy(const Observations& exact, double sd_px, std::uint32_t seed);
// Every photograph shifted by its own Gaussian amount.
void AddSlips(Observations& observations, double sd_px, std::uint32_t seed);

}  // namespace lamella
