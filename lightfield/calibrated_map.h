// The ray map of a layer whose panels stand where a calibration says: the beam of every emitter.
// Its inverse, what a line of sight meets, is LayerSights of lightfield/panel_rays.h.
//
// What the modulator shows is drawn in its own pixels and does not change. What changes is which
// emitters are seen through an opening, and where their light goes.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "lightfield/beam.h"
#include "lightfield/calibration.h"
#include "lightfield/display.h"
#include "lightfield/rigid.h"

namespace lamella {

// InputError naming `where` if the calibration is of another display: its name, number of layers,
// optics, pixels of a panel, their pitch (beyond a fifth) or a reflection differ, or its layers do
// not stand in the display's order.
void CheckCalibrates(const Calibration& calibration, const Display& display,
                     const std::string& where);

// The display with positions and air-equivalent gaps of its layers as calibrated: what needs one
// number for a whole layer. Its border is at most as wide as they are apart.
Display AsCalibrated(const Display& display, const Calibration& calibration);

struct CalibratedBeam {
  Beam beam;        // its central line is exact, its widths are those of upright panels
  double z_mm = 0;  // where the element's centre is: the plane of the beam's element_mm
};

class CalibratedMap {
 public:
  CalibratedMap(const Display& display, const Calibration& calibration, int layer);

  int slots_per_axis() const { return slots_; }
  // The beam of an emitter in a time slot, as LayerMap's: columns and rows as the viewer counts
  // them. Of an emitter and the point (0, 0, D) (without shear: the display's normal) the line
  // through the gap is followed; its light is made for the opening, or the lens, that is nearest to
  // where it leaves. Nothing where that is not whole on the panel, for guard pixels, and where the
  // light stays in the glass. A bare panel's go to the eye box.
  std::optional<CalibratedBeam> BeamOf(int slot, int channel, int column, int row) const;

 private:
  struct Element {
    int column = 0, row = 0;
    Eigen::Vector3d centre;  // in the stack
    Eigen::Vector2d width;   // mm
  };
  // Panel pixels of a place counted in emitters from the viewer's top left, and back.
  Eigen::Vector2d PanelPixelOf(const PanelCalibration& panel, double column, double row) const;
  Eigen::Vector2d EmittersOf(const PanelCalibration& panel, const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector3d> LeavesAt(const Eigen::Vector3d& emitter) const;
  Eigen::Vector3d ToTarget(const Eigen::Vector3d& from) const;
  std::optional<Element> ElementAt(const Eigen::Vector3d& crossing, int slot, int column,
                                   int row) const;
  std::optional<Element> OpeningAt(const Eigen::Vector3d& crossing, int slot) const;
  std::optional<Element> LensAt(const Eigen::Vector3d& crossing, int column, int row) const;
  bool InWindow(const LensletArray& lenses, const Eigen::Vector3d& centre, int column,
                int row) const;
  std::optional<Eigen::Vector3d> Leaving(const Eigen::Vector3d& emitter,
                                         const Eigen::Vector3d& element) const;
  CalibratedBeam BeamFrom(const Element& element, double depth_mm,
                          const Eigen::Vector3d& direction) const;
  CalibratedBeam BareBeam(const BarePanel& bare, const Eigen::Vector3d& emitter, int column,
                          int row) const;
  // Of an emitter along x and y.
  Eigen::Vector2d EmitterWidth() const;

  Optics optics_;
  LayerCalibration layer_;
  Rigid stack_from_emitter_;
  int columns_ = 0, rows_ = 0, binning_ = 1, slots_ = 1;
  bool towards_point_ = true;
  double viewer_mm_ = 0;    // D
  Eigen::Vector3d target_;  // in the stack: a point, or a direction
};

}  // namespace lamella
