// The lattice that fits samples of a lens sheet best, robustly, and how certain it is.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/lattice_model.h"

namespace lamella {

struct LatticeFit {
  LatticeModel model;
  double scale = 0;  // robust standard deviation of the residuals, in the samples' own
  double most = 0;   // deviations beyond which samples count nothing
  int num_used = 0;
  // Of an M-estimator, whose covariance is A^-1 B A^-1: A the cost's second derivative, B the sum
  // of squares of its gradients, of 12 x 12 parts of every view's sheet, since a camera's blur and
  // the panel's staircase of pixels make the errors of neighbours alike.
  Matrix5d curvature = Matrix5d::Zero(), scatter = Matrix5d::Zero();
  std::vector<Eigen::Matrix<double, 5, 3>> eyes;  // the gradient's change per mm of each camera
  std::vector<Vector5d> together;  // its change in each way that cameras may be off together

  // With cameras known so well, each coordinate.
  Matrix5d Covariance(double eye_sd_mm) const;
  LatticeFit WithGapKnown() const;  // as if the gap were given
};

// `start` is within half a lens of the samples everywhere (lattice_search.h), `gap_mm` what the
// design says of the reduced gap: a tenth of it is assumed as its deviation. Reweighted least
// squares with Tukey's weights, from samples within half a lens to those within 4.7 of the rest's
// deviations.
LatticeFit FitLattice(const std::vector<SheetRay>& rays, const std::vector<Eigen::Vector3d>& eyes,
                      const LatticeModel& start, double gap_mm);

// The change of the gradient at the fit were rays as in `moved`, which has them in the same order;
// of NaN where it has not.
Vector5d GradientChange(const std::vector<SheetRay>& rays, const std::vector<SheetRay>& moved,
                        const LatticeFit& fit);

}  // namespace lamella
