// From photographs of a varifocal display's planes, one lit at a time, to the pose and
// magnification of each, and to whether they follow the mirror. Read this first:
//
//   varifocal_observations.h  the input: points of planes, and marks of the frame's printed sheet
//   varifocal_state.h         all that is unknown, its gauge, and which of it is free
//   varifocal_problem.h       residuals of all photographs, and their minimiser
//   varifocal_start.h         starting values
//   varifocal_solve.h         the joint robust solution; which bends the photographs ask for
//   varifocal_rays.h          how well pixels on lines of sight are known
//   next_plane_view.h         from where to photograph next
//   mirror_model.h            the smooth model in the mirror's phase
//
// calibration.md has the measurements behind each choice.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/calibrate.h"
#include "calibration/mirror_model.h"
#include "calibration/next_plane_view.h"
#include "calibration/varifocal_observations.h"
#include "calibration/varifocal_solve.h"
#include "lightfield/calibration.h"
#include "lightfield/display.h"
#include "lightfield/rigid.h"

namespace lamella {

struct CalibrateVarifocalOptions {
  EyeBox eye_box;
  // What planes must be known to, as standard deviations: half of 0.03 mm and of 1e-4.
  double largest_depth_sd_mm = 0.015, largest_magnification_sd = 5e-5;
  // Where the sheet is fixed in the display. Without it the display stands so that its planes'
  // corners are nearest to where they are designed.
  std::optional<Rigid> display_from_frame;
};

// A plane as measured: its panel's middle, axes and size in the display's frame.
struct CalibratedPlane {
  Rigid display_from_plane;
  double magnification = 1, bow_mm = 0, pincushion = 0;
  // Of rotation (rad, about the display's axes), position (mm) and magnification, against the
  // frame's sheet.
  Eigen::Matrix<double, 7, 7> covariance;
  double depth_sd_mm = 0, magnification_sd = 0, tilt_sd_rad = 0;  // tilt: the worse of two axes
  double depth_with_magnification = 0;  // their correlation: nearer to -1 the smaller the angles
};

struct VarifocalReport {
  Calibration calibration;  // in the display's frame; a layer for each plane
  std::vector<CalibratedPlane> planes;
  Eigen::MatrixXd covariance;  // joint, 7 a plane as in CalibratedPlane; empty: not known
  MirrorModel mirror;
  Rigid display_from_frame;
  std::vector<Camera> cameras;
  std::vector<Rigid> camera_from_display;  // of each view
  std::vector<FitOf> planes_fit, views_fit;
  double slip_px = 0;          // tau
  double chi2 = 0;             // per degree of freedom, of all
  double view_angles_deg = 0;  // the widest between two views' directions, as seen from the planes
  RayUncertainty rays;         // varifocal_rays.h
  std::vector<ProbedRay> probed;       // that `rays` has deviations of
  std::vector<ResidualMap> residuals;  // of each plane
  CalibrateVarifocalOptions limits;    // what was asked for
  Degeneracy degeneracy;
  std::vector<GroupVerdict> groups;
  std::optional<NextPlaneView> next_view;  // which photographs would help most
  std::vector<std::string> rejected;       // photographs and views left out, and why
  // Where `failures` is not empty the calibration is not to be used (exit code 4).
  std::vector<Weakness> failures, warnings;
  bool accepted() const { return failures.empty(); }
};

// UsageError where the display is not varifocal; InputError where there is no starting point
// (varifocal_start.h) or a plane in no photograph. A failure where a plane's depth or magnification
// is not known well enough, with what is lost and the photograph that cures it.
VarifocalReport CalibrateVarifocal(const VarifocalObservations& given, const Display& display,
                                   const CalibrateVarifocalOptions& options = {});

// What the mirror's model says, in one line.
std::string Describe(const MirrorModel& mirror);

}  // namespace lamella
