// How much photographs of one camera position are shifted against one another.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/residuals.h"

namespace lamella {

// A least-squares solution that slips are a part of.
struct SlipSolution {
  const NormalEquations& equations;  // with the prior of slips
  const std::vector<int>& columns;   // first of 2, of each slip
  int num_others = 0;                // columns before those of slips
  const std::vector<Eigen::Vector2d>& slips_px;
  double slip_sd_px = 0;  // tau, of the prior
  double variance = 1;    // chi^2 per degree of freedom
};

// The deviation tau (px) of photographs' slips that makes the data most probable, all other
// parameters integrated out in the linearised problem (restricted maximum likelihood; Patterson and
// Thompson 1971). From 0.001 px, as good as absent, to 0.3 px: what moved more is an error and no
// noise. Covariances that are stated too small by a common factor are allowed for.
double EstimateSlip(const SlipSolution& solution);

}  // namespace lamella
