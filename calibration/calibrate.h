// From the photographs' points to a display's calibration. Read this first:
//
//   observations.h   the input: points of panels and where photographs show them
//   model.h          the model of one photograph: a panel's pixel to the photograph's
//   state.h          all that is unknown, and which of it is free
//   residuals.h      residuals of all photographs and their normal equations
//   problem-inl.h    the same as Ceres takes them; minimise.h: its minimiser
//   initialise.h     starting values, from one homography per panel and photograph
//   panel_edges.h    points that another panel's edge displaces
//   solve.h          the joint robust solution; slip.h: photographs of one position that moved
//   select.h         which groups of parameters the photographs ask for and carry
//   uncertainty.h    how well rays are known, and what the photographs leave open
//   gates.h          what the residuals say against the solution
//   residual_map.h   where on its panels it fits; next_view.h: from where to photograph next
//
// Lens sheets are a problem of their own: lattice.h. calibration.md has the measurements behind
// each choice.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/next_view.h"
#include "calibration/observations.h"
#include "calibration/residual_map.h"
#include "calibration/select.h"
#include "calibration/uncertainty.h"
#include "lightfield/calibration.h"
#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

struct CalibrateOptions {
  EyeBox eye_box;
  double largest_ray_rms_px = 0.03;  // of the ray map's standard deviation
  double largest_ray_max_px = 0.10;  // likewise, the worst ray
};

// How well the points of some photographs fit.
struct FitOf {
  std::string name;  // "layer 0 emitter", "view 3" (the third camera position)
  int num_points = 0, num_used = 0;
  double rms_px = 0;  // of the used points' distance
  double chi2 = 0;    // per degree of freedom, points' own
};

// A parameter's standard deviation, from the joint covariance of all.
struct ParameterDeviation {
  std::string name;  // "layer 1 gap"
  std::string unit;  // "mm", "rad", "px" or none
  double sd = 0;
};

// What the photographs do not settle, and which photograph would.
struct Weakness {
  std::string lost, cure;
};

struct CalibrationReport {
  Calibration calibration;  // in the display's frame, the reference stack as designed
  PanelId reference;
  std::vector<Camera> cameras;
  std::vector<int> views;
  std::vector<Rigid> camera_from_display;  // of each view
  std::vector<FitOf> panels, views_fit;
  double slip_px = 0;  // tau
  double chi2 = 0;     // per degree of freedom, of all
  RayUncertainty rays;
  std::vector<ProbedRay> probed;               // that `rays` has deviations of
  std::vector<ParameterDeviation> deviations;  // of cameras and display; empty: some are unknown
  std::vector<ResidualMap> residuals;          // of each panel
  CalibrateOptions limits;                     // what was asked for
  std::optional<NextView> next_view;           // which photograph would help most
  Degeneracy degeneracy;
  std::vector<GroupVerdict> groups;
  std::vector<std::string> rejected;  // photographs left out, and why
  std::vector<std::string> at_edges;  // panels with points that another's edge cuts: ClearOfEdges
  // Where `failures` is not empty the calibration is not to be used (exit code 4).
  std::vector<Weakness> failures, warnings;
  bool accepted() const { return failures.empty(); }
};

// `design` is the display as built on paper (DesignCalibration): sizes, pitches, gaps, indices,
// mirrors and plates, and starting values of nothing else. The world's length is the reference
// panel's pitch. InputError or UsageError where there is no starting point (initialise.h).
CalibrationReport Calibrate(const Observations& given, const Calibration& design,
                            const CalibrateOptions& options = {});

}  // namespace lamella
