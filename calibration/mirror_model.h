// Do a varifocal display's planes, each calibrated on its own, follow their mirror?
// calibration.md sections 3 and 6.
//
// Every number of a plane (rotation, position, magnification) is a sum of harmonics of the mirror's
// phase, a_0 + a_1 cos(phase) + ... + a_J cos(J phase): with J = 1 all of them follow the
// membrane's deflection evenly, more are what a membrane does that is not quite a membrane.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "lightfield/display.h"

namespace lamella {

using PlaneNumbers = Eigen::Matrix<double, 7, 1>;  // rotation (rad), position (mm), magnification

// In (0, pi), falling cosines from the back to the front: the phase of a membrane in resonance at
// every plane. Of planes at equal times (sinusoidal) pi (k + 1/2)/K, of others the time at which
// the same membrane passes their depth.
std::vector<double> MirrorPhases(const Varifocal& varifocal);

struct MirrorModel {
  bool tested = false;  // there are more planes than the model has coefficients
  int harmonics = 1;    // J, of 1 to 3 that of the smallest BIC
  double chi2 = 0;      // of all numbers of all planes about the model
  int freedom = 0;
  // Whether chi^2 per degree of freedom is within four standard deviations of 1: what the planes
  // deviate by is what the photographs leave open.
  bool holds = false;
  // RMS over the planes of deviations from the model, and of what is stated of them.
  double depth_rms_mm = 0, depth_sd_mm = 0;
  double magnification_rms = 0, magnification_sd = 0;
  int worst_plane = 0;                   // the least probable
  double worst_depth_mm = 0;             // its deviation
  std::vector<PlaneNumbers> deviations;  // plane by plane, from the model

  // M = M0 + z/f of a thin lens whose image moves by z: 1/f and M0, with standard deviations, and
  // whether the planes' magnifications obey it, by the same measure.
  bool relay_holds = false;
  double relay_power_per_mm = 0, relay_power_sd = 0;
  double magnification0 = 0, magnification0_sd = 0;
  double relay_chi2 = 0;
  int relay_freedom = 0;
};

// `numbers` with their joint covariance, 7 columns a plane; rotations about a common mean. Not
// tested where the planes are too few or the covariance is not positive definite.
MirrorModel FitMirrorModel(const std::vector<PlaneNumbers>& numbers,
                           const Eigen::MatrixXd& covariance, const std::vector<double>& phases);

}  // namespace lamella
