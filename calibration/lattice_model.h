// Samples of a lens sheet as lens centres, and the lattice's equations for them. The public side
// is calibration/lattice.h, which has the formulas.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "calibration/lattice.h"
#include "lightfield/calibration.h"

namespace lamella {

using Vector5d = Eigen::Matrix<double, 5, 1>;

// A sample in mm.
struct SheetRay {
  int view = 0;
  Eigen::Vector2d sheet{0, 0};  // q
  Eigen::Vector2d panel{0, 0};  // X
  Eigen::Vector2d slope{0, 0};  // w
  Eigen::Vector2d sigma{1, 1};  // of X
};
// Multiples of the period are those with which X is nearest to what the design shows at q without a
// lens: half a lens away at most. InputError where an index, size or number is not possible.
std::vector<SheetRay> SheetRaysOf(const LatticeObservations& observations,
                                  const LayerCalibration& design);

// Lens centres lie on the lines n_a . c = (k + phi_a) P of each family a: one of a line's, two of a
// square's; three of a hexagonal lattice's, 60 degrees apart, the third of which follows from the
// others (phi_2 = phi_1 - phi_0) but treats all directions alike.
class LatticeModel {
 public:
  explicit LatticeModel(const LensLattice& lattice);

  int num_families() const { return num_families_; }
  double FamilyWeight() const {
    return num_families_ == 3 ? 2.0 / 3 : 1;
  }  // sum n n^T w = I in 2-D
  double SpacingMm(const Vector5d& at) const { return at(kLatticePitch) * spacing_; }
  Eigen::Vector2d Normal(const Vector5d& at, int family) const;
  double Phase(const Vector5d& at, int family) const;  // lenses

  Eigen::Vector2d CentreOf(const SheetRay& ray, double gap) const;  // c, from X

  struct Residual {
    double mm = 0;     // off the nearest line of the family
    double sigma = 0;  // of it
    Vector5d slopes;   // against the parameters
  };
  Residual ResidualOf(const SheetRay& ray, const Vector5d& at, int family) const;
  // Its change per mm of the camera's position, the place on the sheet being known.
  Eigen::Vector3d SlopesOfEye(const SheetRay& ray, const Eigen::Vector3d& eye, const Vector5d& at,
                              int family) const;
  // That of the panel's point seen by an eye through a lens at a place of the sheet, in as many
  // directions as the lattice has: rows against the parameters, mm.
  Eigen::Matrix<double, 2, 5> SlopesOfDrift(const Vector5d& at, const Eigen::Vector2d& place,
                                            const Eigen::Vector3d& eye) const;

 private:
  // dc/dX: F/f.
  double Magnification(double gap) const { return focal_ > 0 ? focal_ / gap : 1; }

  int num_families_ = 1;
  double turn_ = 0, spacing_ = 1, focal_ = 0;
};

}  // namespace lamella
