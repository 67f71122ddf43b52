// Samples of a lens sheet as lens centres, and the lattice's equations for them. The public side
// is calibration/lattice.h, which has the formulas.
#pragma once

#include <algorithm>
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
  Eigen::Vector2d panel{0, 0};  // X, on a flat panel parallel to the sheet
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
  LatticeModel(const LensLattice& lattice, const Vector5d& at);
  // The same sheet with other numbers.
  LatticeModel At(const Vector5d& at) const;

  const Vector5d& parameters() const { return at_; }
  int num_families() const { return num_families_; }
  int num_directions() const { return std::min(2, num_families_); }  // in which lenses bend light
  // With these, the sum of n n^T over the families is the identity.
  double FamilyWeight() const { return num_families_ == 3 ? 2.0 / 3 : 1; }
  double SpacingMm() const { return at_(kLatticePitch) * spacing_; }  // P
  const Eigen::Vector2d& Normal(int family) const { return normals_[Index(family)]; }

  Eigen::Vector2d CentreOf(const SheetRay& ray) const;  // c, from X

  struct Residual {
    double mm = 0;     // off the nearest line of the family
    double sigma = 0;  // of it
    Vector5d slopes;   // against the parameters
  };
  Residual ResidualOf(const SheetRay& ray, const Eigen::Vector2d& centre, int family) const;
  // Its change per mm of the camera's position, the place on the sheet being known.
  Eigen::Vector3d SlopesOfEye(const SheetRay& ray, const Eigen::Vector3d& eye, int family) const;
  // Change of the panel's point that an eye sees through the lens at a place of the sheet: mm
  // against the parameters, in the plane; of a line across its lenses and 0.
  Eigen::Matrix<double, 2, 5> SlopesOfDrift(const Eigen::Vector2d& place,
                                            const Eigen::Vector3d& eye) const;

 private:
  static std::size_t Index(int family) { return static_cast<std::size_t>(family); }

  Vector5d at_;
  int num_families_ = 1;
  double turn_ = 0, spacing_ = 1, focal_ = 0;
  double magnification_ = 1;  // dc/dX: F/f
  std::array<Eigen::Vector2d, 3> normals_, along_;
  std::array<double, 3> phases_{};
};

}  // namespace lamella
