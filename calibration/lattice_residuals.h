// Where on its sheet a lattice does not fit: what one pitch, rotation, phase and gap leave over.
#pragma once

#include <cstddef>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/lattice_model.h"
#include "calibration/residual_map.h"
#include "lightfield/calibration.h"

namespace lamella {

// Mean residuals of 8 x 5 parts of the sheet before the panel, across the lenses of the family that
// is off the most.
struct LatticeMisfit {
  double largest_mm = 0;           // of a part's mean, without sign
  Eigen::Vector2d place_mm{0, 0};  // where
  double deviation_mm = 0;         // standard deviation that chance gives a part's mean
  ResidualMap map;                 // as LatticeReport has it
};
// Of samples within `most` of their own deviations. Chance is judged by how the means of a part's
// quarters differ, so that it counts errors that neighbours share.
LatticeMisfit MisfitOf(const std::vector<SheetRay>& rays, const LatticeModel& model, double most,
                       const PanelCalibration& panel);

// How the samples of every view fit, those used that FitLattice uses: rms_px of one direction, chi2
// in their own deviations.
std::vector<FitOf> FitsOfViews(const std::vector<SheetRay>& rays, const LatticeModel& model,
                               double most, std::size_t num_views, double pixel_mm);

}  // namespace lamella
