// The least-squares problem of a varifocal display's photographs, by Ceres. calibration.md
// sections 1 and 5.
//
// A point's residual is L^T (predicted - measured) with L L^T the inverse of its covariance; a
// photograph's slip d adds d/tau. A plane's point is where its panel's pixel lies (PanelPoint of
// calibration/model.h) with the plane's own magnification, bow and pincushion.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/minimise.h"
#include "calibration/residuals.h"
#include "calibration/varifocal_state.h"

namespace lamella {

// The whitened residuals, 2 x points, of each photograph of a plane, then of each view's marks.
std::vector<Eigen::Matrix2Xd> WhitenedResiduals(const VarifocalState& state,
                                                const std::vector<PanelCalibration>& planes,
                                                const VarifocalObservations& observations);

// In the columns' tangent space, of the points that count; without a loss.
NormalEquations Linearise(const VarifocalState& state, const std::vector<PanelCalibration>& planes,
                          const VarifocalColumns& columns,
                          const VarifocalObservations& observations, const Weighting& weighting);

// Levenberg-Marquardt from `state`, in place. With options.hold_display views and slips alone are
// free.
Settling Minimise(const std::vector<PanelCalibration>& planes, const VarifocalColumns& columns,
                  const VarifocalObservations& observations, const Weighting& weighting,
                  const MinimiseOptions& options, VarifocalState& state);

}  // namespace lamella
