// All that a calibration estimates, as numbers, and which of them are free: the columns of its
// least-squares problem. calibration.md sections 1 and 2.
//
// The world is the reference stack's frame (that is the gauge): the reference's pose, pitch and
// shape are constant.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "lightfield/calibration.h"
#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

// Where the errors of a solve say that they happened.
inline constexpr const char* kSolveWhere = "calibration";

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// A photograph's camera: fx, fy, cx, cy (px), k1, k2, p1, p2, k3.
using LensParameters = Vector9d;
Camera CameraOf(const LensParameters& lens, int width_px, int height_px);

struct LayerState {
  Rigid world_from_stack;
  Vector6d relation = Vector6d::Zero();  // offset x, offset y, gap (mm), rotation vector (rad)
  Eigen::Vector4d emitter_shape{0, 0, 0, 0}, modulator_shape{0, 0, 0, 0};  // s, a, k, bow (mm)
  double index = 1;
  double plate_mm = 0;
};

struct CalibrationState {
  std::vector<LensParameters> cameras;
  std::vector<Rigid> camera_from_world;  // of each view, by its place in Structure::views
  std::vector<LayerState> layers;
  std::vector<Eigen::Vector2d> slips_px;  // of each photograph of Observations
};

// Groups that calibration.md section 6 frees only where the data ask for it.
struct FreeGroups {
  bool k3 = false;
  bool scale = false;        // of every panel but the reference
  bool aspect_skew = false;  // likewise
  bool bow = false;          // of every panel
  bool index = false;        // of every gap
  bool plate = false;        // thickness where the design has one
  bool slip = true;          // a shift of every photograph, with a prior
  std::vector<int> air;      // layers whose index is 1, whatever else is free
  friend bool operator==(const FreeGroups&, const FreeGroups&) = default;
};

// What is fixed about the problem: design, photographs, reference.
struct Structure {
  Calibration design;
  PanelId reference;
  std::vector<int> views;           // numbers of the views, sorted
  std::vector<int> camera_of_view;  // of each
  std::vector<int> view_of_photo;   // of each photograph, its place in `views`
  std::vector<PanelId> panels;      // that were photographed, sorted
  const PanelCalibration& Panel(const PanelId& panel) const;
};
// UsageError where the design lacks a photographed panel; InputError where there is nothing.
Structure StructureOf(const Observations& observations, const Calibration& design);
// All panels of a display, of which there are no photographs.
Structure StructureOf(const Calibration& design);

// Columns of the tangent space: rotations have 3 (radians, about the world's axes), translations 3.
struct Columns {
  int size = 0;
  std::vector<int> camera;  // first of 9 each; k3 may be missing
  bool k3 = false;
  std::vector<int> view, slip;       // first of 6 (rotation, translation) and of 2
  std::vector<int> stack, relation;  // first of 6 per layer, -1: constant
  std::vector<std::array<int, 4>> emitter_shape, modulator_shape;  // each -1 or its column
  std::vector<int> index, plate;                                   // -1 or column, per layer
  std::vector<std::string> names;                                  // "layer 1 gap", of each column
  std::vector<std::string> units;                                  // "mm", "rad", "px", "" of each
  std::vector<double> prior_sd;  // what a display builder would assume (section 6), per column
  int num_camera = 0;            // cameras come first,
  int num_display = 0;           // then the display, to here; then views
  int first_slip = 0;            // slips are the last columns
};
Columns ColumnsOf(const Structure& structure, const FreeGroups& free,
                  const Observations& observations);

CalibrationState Plus(const CalibrationState& state, const Columns& columns,
                      const Eigen::VectorXd& step);

// The design's numbers, with cameras and views at zero.
CalibrationState StateOfDesign(const Structure& structure, const Observations& observations);
// In the display's frame, where the reference stack stands as designed.
Calibration CalibrationOf(const CalibrationState& state, const Structure& structure);

}  // namespace lamella
