// The ray map of slanted lenticular lenses over a striped panel (displays.md section 3; van Berkel,
// SPIE 3639, 1999), and its inverse. An emitter is a sub-pixel, a third of a pixel wide.
//
// The cylinders bend light across them only. So an emitter is seen from all heights, and the slope
// dx/dz along which it is seen depends on the height by the slant: sx = -offset/d0 - sy tan alpha.
#pragma once

#include <optional>

#include "lightfield/beam.h"
#include "lightfield/display.h"

namespace lamella {

// The view in [0, N) of sub-pixel k from the left (3 column + channel) and row l from the top
// (van_berkel): ((k + k_off - 3 l tan alpha) mod X)/X N. 0 is at a lens's left edge, which is seen
// from the right; N/2 is under its vertex. Real arguments are places between sub-pixels.
double VanBerkelView(const Lenticular& lenses, double subpixel, double row);

class LenticularMap {
 public:
  LenticularMap(const Display& display, int layer);  // UsageError where the layer is otherwise

  double View(int channel, int column, int row) const;
  // The beam of a sub-pixel to the viewer's height: at (0, 0, D) with the display's shear, level
  // without. Along x it is a lens's; along y the emitter's height at every depth, for there is no
  // parallax. Nothing outside of the panel.
  std::optional<Beam> BeamOf(int channel, int column, int row) const;
  // What the line through (x_mm, y_mm) on the modulating plane with slopes dx/dz, dy/dz meets.
  // element_column is the lens's number.
  std::optional<Sight> See(double x_mm, double y_mm, double slope_x, double slope_y) const;

 private:
  // Sub-pixels right of the vertex of the lens over a place, and the lens's number.
  struct Place {
    int lens = 0;
    double offset_subpx = 0;
  };
  Place PlaceOf(double subpixel, double row) const;
  // A panel that is seen in a mirror has its stripes in reverse.
  int Stripe(int channel) const { return mirrored_ ? 2 - channel : channel; }

  Lenticular lenses_;
  int columns_ = 0, rows_ = 0;
  double pitch_mm_ = 0, d0_mm_ = 0, power_per_mm_ = 0;
  double viewer_mm_ = 0;  // from the emitters; 0: at infinity
  bool mirrored_ = false;
};

}  // namespace lamella
