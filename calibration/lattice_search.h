// Where a lens lattice is, roughly, in samples of its lens centres: good enough that every sample
// is told to its own lens.
#pragma once

#include <vector>

#include "calibration/lattice_model.h"

namespace lamella {

// The numbers of the maximum over pitch and rotation, near the design's, of the samples'
// periodogram
//   sum over views and families of |sum exp(2 pi i n_a . c / P)|^2
// on a grid of half its resolution; then the gap and the phases at which all views' sums agree.
// Samples need not be sorted to lenses, wrong ones add noise only. InputError where no maximum
// stands out of what samples without a lattice would give, or it lies on the search's border.
Vector5d FindLattice(const std::vector<SheetRay>& rays, const std::vector<Eigen::Vector3d>& eyes,
                     const LatticeModel& design);

}  // namespace lamella
