// All that calibrating a varifocal display estimates, as numbers, and which of them are free.
// calibration.md sections 1 and 2.
//
// The world is the frame, whose printed marks give position, direction and length: that is the
// whole gauge. A plane's magnification and its depth are told apart by parallax alone: the smaller
// the angles of the views, the more they go together (correlation -0.84 within 4 degrees).
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/residuals.h"
#include "calibration/state.h"
#include "calibration/varifocal_observations.h"
#include "lightfield/calibration.h"
#include "lightfield/rigid.h"

namespace lamella {

// s (magnification less 1), a, k, bow in mm, pincushion: of PanelCalibration.
using PlaneShape = Eigen::Matrix<double, 5, 1>;

struct PlaneState {
  Rigid frame_from_plane;
  PlaneShape shape = PlaneShape::Zero();
};

struct VarifocalState {
  std::vector<LensParameters> cameras;
  std::vector<Rigid> camera_from_frame;  // of each view
  std::vector<PlaneState> planes;
  // Of each photograph of a plane, then of each view's marks.
  std::vector<Eigen::Vector2d> slips_px;
};

// Groups that are freed only where the data ask for them and carry them (calibration.md section 6).
struct VarifocalGroups {
  bool bow = false, pincushion = false;  // of every plane
  bool slip = true;                      // a shift of every photograph, with a prior
  friend bool operator==(const VarifocalGroups&, const VarifocalGroups&) = default;
};

// Columns of the tangent space. Of `common` cameras (8: without k3; -1: known beforehand), views
// (-1: likewise), slips, names and bounds are used; planes are its display.
struct VarifocalColumns {
  Columns common;
  std::vector<int> plane;  // first of 7: rotation (about the frame's axes), position, magnification
  std::vector<std::array<int, 2>> bent;  // bow, pincushion; each -1 or its column
};
VarifocalColumns ColumnsOf(const VarifocalObservations& observations, std::size_t num_planes,
                           const VarifocalGroups& free);

// The planes' panels as designed: one for each layer of the design.
std::vector<PanelCalibration> PlanesOf(const Calibration& design);
PlaneShape ShapeOf(const PanelCalibration& panel);
PanelCalibration WithShape(PanelCalibration panel, const PlaneShape& shape);

// What is photographed: a plane, or the marks of a view (plane -1).
struct VarifocalPhoto {
  int plane = -1, view = 0;
  std::string label;
  std::size_t num_points = 0;
};
// In the order of slips.
std::vector<VarifocalPhoto> PhotosOf(const VarifocalObservations& observations);

}  // namespace lamella
