// A lens sheet's pitch, rotation, phase and reduced gap from photographs of phase patterns under
// it. calibration.md sections 1, 2 and 11; lengths in mm, in the stack's frame
// (lightfield/calibration.h).
//
// A line of sight that meets the sheet at q shows the panel's point
//   X = c + f w(q) + (1 - f/F)(q - c)
// with c the centre of the lens at q, f = gap / index, w the slope of the line of sight (n times
// that behind the surface, by Snell's law) and F the lenses' focal length; F = f leaves
// c = X - f w: of lens k, at c, s_k (1 + f/D) - e_s f/D along a normal of the lattice. So every
// sample names a lens's centre, and the centres lie on the lattice.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calibration/calibrate.h"
#include "lightfield/calibration.h"

namespace lamella {

// What one pixel of a photograph says.
struct LatticeSample {
  int view = 0;                    // in LatticeObservations::eyes_mm
  Eigen::Vector2d sheet_mm{0, 0};  // q, where its line of sight meets z = 0
  Eigen::Vector2d panel_px{0, 0};  // what it shows, decoded
  Eigen::Vector2d sigma_px{1, 1};  // standard deviations of that, relative to one another
};

struct LatticeObservations {
  std::vector<Eigen::Vector3d> eyes_mm;  // the camera's centre in each view
  std::vector<LatticeSample> samples;
  // panel_px is known up to multiples of this (the finest period alone was decoded); 0: as it is.
  // Should exceed the lenses' width by six standard deviations.
  double period_px = 0;
};

// How the cameras' errors go together, where one board tells all of them: what the samples would
// be, were the cameras one standard deviation off in each of independent ways.
struct CameraErrors {
  int num_ways = 0;
  std::size_t every = 1;  // samples 0, every, 2 every ... stand for all
  // Of these, in one of the ways, in the same order.
  std::function<LatticeObservations(int way)> off;
};

struct LatticeOptions {
  EyeBox eye_box;          // of the viewers, in the display's frame
  double eye_sd_mm = 0.3;  // how well each coordinate of a camera is known: half a mm in all
  CameraErrors camera_errors = {};  // beside these
  double largest_drift_px = 0.02;
};

// The order of LatticeReport::covariance.
enum LatticeParameter {
  kLatticePitch,
  kLatticeRotation,
  kLatticePhase0,
  kLatticePhase1,
  kLatticeGap
};
using Matrix5d = Eigen::Matrix<double, 5, 5>;

// Standard deviation of the panel's point that eyes of the box see through a lens, px: over the
// eyes the root mean square and the largest.
struct LensDrift {
  double rms_px = 0, max_px = 0;
};

struct LatticeReport {
  LayerCalibration layer;  // the design with its lattice and its gap as measured
  // Of pitch (mm), rotation (rad), phases (lenses) and reduced gap (mm): of the samples' noise, as
  // it is correlated over parts of the sheet, and of the cameras' positions. A line's second phase
  // has none.
  Matrix5d covariance = Matrix5d::Zero();
  // LensDrift in the direction in which it is largest, of 3 x 3 places from edge to edge.
  double drift_rms_px = 0, drift_max_px = 0;
  double largest_drift_px = 0;         // what was asked for
  std::array<LensDrift, 9> drift;      // at the places, row by row from the top left
  Eigen::Vector2d worst_px{0, 0};      // the panel's pixel before which the worst lens lies
  Eigen::Vector3d worst_eye{0, 0, 0};  // and who sees it, in the display's frame
  int num_samples = 0, num_used = 0;   // used: within 4.7 deviations of the lattice
  double noise_px = 0;                 // robust standard deviation of a sample about the lattice
  double chi2 = 0;                     // its square, in the samples' own deviations
  int num_views = 0;                   // with samples
  std::vector<FitOf> views_fit;        // of each of eyes_mm
  std::vector<double> apart_mm;        // cameras, the farthest two, across each family of lenses
  // Of samples within 4.7 deviations, in 8 x 5 parts of the sheet before the panel as seen from the
  // front: lens centres as decoded less those of the lattice, in the panel's pixels, right and
  // down; of a line's across its lenses.
  ResidualMap residuals;
  double largest_mean_px = 0;  // that a part may be off across a family: 0.03 and what chance does
  // Where a further camera would tell pitch and phase from the gap, in the display's frame; none
  // where positions are apart enough.
  std::optional<Eigen::Vector3d> next_eye;
  // Where `failures` is not empty the lattice is not to be used.
  std::vector<Weakness> failures, warnings;
  bool accepted() const { return failures.empty(); }
};

// `design` has the panel's size and place, the index, the lattice's type and focal length; its
// pitch may be 1.5 % off, its rotation 1.5 degrees, its gap a third. Phases come out in [0, 1), the
// rotation is that nearest the design's. Fails by name: one camera position, or positions too near
// one another (pitch and phase with the gap), too little of the panel or too much noise, more than
// 35 % of the samples off the lattice, a part of the sheet (of 8 x 5) off it by more than 0.03 px
// on the mean, beyond what chance does. UsageError where the layer has no lenses; InputError where
// samples make no sense or no lattice like the design's is in them.
LatticeReport EstimateLattice(const LatticeObservations& observations,
                              const LayerCalibration& design, const LatticeOptions& options = {});

}  // namespace lamella
