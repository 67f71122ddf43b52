// How much photographs of one camera position are shifted against one another.
#pragma once

#include "calibration/solve.h"

namespace lamella {

// The deviation tau (px) of photographs' slips that makes the data of `fit` most probable, all
// other parameters integrated out in the linearised problem (restricted maximum likelihood;
// Patterson and Thompson 1971). From 0.001 px, as good as absent, to 0.3 px: what moved
// more is an error and no noise.
// Covariances that are stated too small by a common factor are allowed for. `fit` is left as it is.
double EstimateSlip(const Fit& fit);

}  // namespace lamella
