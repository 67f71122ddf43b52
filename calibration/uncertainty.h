// What a calibration is for is to know which pixels lie on one ray, so that is what its uncertainty
// is stated of. calibration.md sections 1 and 7.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/solve.h"
#include "lightfield/calibration.h"

namespace lamella {

// Eyes 3 x 3 x 3 in the display's frame, mm.
struct EyeBox {
  double half_width_mm = 290, half_height_mm = 100;
  double near_mm = 650, far_mm = 950;
  std::vector<Eigen::Vector3d> Eyes() const;
};

// A ray: from an eye through a pixel of the reference panel, and a panel that it meets.
struct ProbedRay {
  PanelId panel;
  Eigen::Vector2d reference_px;
  Eigen::Vector3d eye_mm;
};
// 7 x 5 pixels of the reference panel from edge to edge, where errors are largest, all eyes, every
// other panel, in a fixed order.
std::vector<ProbedRay> RaysToProbe(const Structure& structure, const EyeBox& box);

// The pixels that a calibration gives for the rays, 2 x rays; NaN where it never meets the panel.
Eigen::Matrix2Xd PixelsOfRays(const Calibration& calibration, const PanelId& reference,
                              const std::vector<ProbedRay>& rays);

// Root mean square and largest length of a difference of two ray maps, over rays in both.
struct RayDifference {
  double rms_px = 0, max_px = 0;
};
RayDifference CompareRays(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b);

// The slopes J of the rays' pixels, two rows for each ray, against the display's parameters (the
// first Columns::num_display; a camera changes no ray). By central differences of `steps`.
Eigen::MatrixXd SlopesOfRays(const Fit& fit, const Structure& structure,
                             const std::vector<ProbedRay>& rays, const Eigen::VectorXd& steps);

// Standard deviation of the ray map (of the length of its error, both coordinates together).
struct RayUncertainty {
  double rms_sd_px = 0, max_sd_px = 0;
  ProbedRay worst;
  std::vector<double> sd_px;  // of every ray; NaN where it never meets the panel
};
// J C J^T, of a covariance of the display's parameters.
RayUncertainty UncertaintyOfRays(const std::vector<ProbedRay>& rays, const Eigen::MatrixXd& slopes,
                                 const Eigen::MatrixXd& covariance);
// The same, with J by steps of a twentieth of each parameter's deviation.
RayUncertainty UncertaintyOfRays(const Fit& fit, const Structure& structure,
                                 const Eigen::MatrixXd& covariance, const EyeBox& box);

// How well the photographs carry every direction of the parameters: the smallest eigenvalue of
// D H D, with D what a builder would assume beforehand (Columns::prior_sd), is how many times (as a
// square) they know the weakest direction better than that. 100 and more is asked for.
struct Degeneracy {
  double smallest = 0;
  Eigen::VectorXd direction;  // of the weakest, in units of the assumptions
};
Degeneracy DegeneracyOf(const NormalEquations& equations, const Columns& columns, double variance);
Degeneracy DegeneracyOf(const Fit& fit);
// The parameters that make up most of it, by name: "layer 1 gap, camera body focal x".
std::string NameOfDirection(const Degeneracy& degeneracy, const Columns& columns);

}  // namespace lamella
