// From a calibrated panel's pixels to points, and along lines of sight to its pixels: the formulas
// of calibration.md section 1. Lengths in mm.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "lightfield/calibration.h"

namespace lamella {

// The point of a panel's pixel (u, v) in the panel's frame, and the pixel of the point above
// (x, y): inverse of its first two coordinates, to 1e-12 of the panel's size. Nothing where a
// barrel-shaped panel (pincushion < 0) never reaches.
Eigen::Vector3d PanelPoint(const PanelCalibration& panel, const Eigen::Vector2d& pixel);
std::optional<Eigen::Vector2d> PanelPixel(const PanelCalibration& panel,
                                          const Eigen::Vector2d& point_mm);

// Where the line meets the (bowed) panel, all in the panel's frame: the point that is continuous in
// the bow. Nothing where it passes by.
std::optional<Eigen::Vector3d> MeetPanel(const PanelCalibration& panel,
                                         const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction);

Rigid StackFromEmitter(const LayerCalibration& layer);

// The unit direction in matter of an index >= 1 of a line that comes from air through a plane
// z = const (Snell). `direction` need not be unit.
Eigen::Vector3d Refract(const Eigen::Vector3d& direction, double index);

// The two-point form: an eye at height `d` before the interface, a point at depth z behind it in
// matter of an index, sideways distance L between them: how far from the eye's foot the light
// crosses, r in [0, L] with r/sqrt(r^2 + d^2) = n w/sqrt(w^2 + z^2), w = L - r.
double RefractionCrossing(double d, double z, double L, double index);

// By how much a plate displaces a line of direction d: t (d'/(d'.m) - d/(d.m)).
Eigen::Vector3d PlateShift(const Plate& plate, const Eigen::Vector3d& direction);

// The centre of the lens above a point (of a line lens: the nearest point of its axis).
Eigen::Vector2d NearestLens(const LensLattice& lattice, const Eigen::Vector2d& point_mm);

// What a line of sight meets of a layer.
struct SightHit {
  Eigen::Vector2d modulator{0, 0};  // px; unused where the layer has no modulator
  Eigen::Vector2d emitter{0, 0};    // px, may lie beside the panel
  double cosine = 1;                // of its angle in air to the stack's normal
};

// A layer in the display's frame, ready to be looked at.
class LayerSights {
 public:
  explicit LayerSights(const LayerCalibration& layer);

  // The line of sight from `origin` (in front of the layer) along `direction`, in the display's
  // frame: displaced by the plate, straight to the modulator, refracted at the plane z = 0 of the
  // stack, bent by the lens where there is one (the ray through its centre by Snell, the others of
  // its pencil by its focal length), on to the emitter. Nothing where it looks away or passes by.
  std::optional<SightHit> Seen(const Eigen::Vector3d& origin,
                               const Eigen::Vector3d& direction) const;

 private:
  LayerCalibration layer_;
  Eigen::Matrix3d stack_from_display_, emitter_from_stack_;  // rotations
  Eigen::Vector3d stack_origin_, emitter_origin_;            // in the frame before
};

}  // namespace lamella
