// The ray map of square and hexagonal lenslets with guard pixels (displays.md section 3), and its
// inverse. Lattice coordinates are emitters from the panel's top left corner, right and down; a
// pixel's centre is at its index + 1/2.
#pragma once

#include <optional>

#include "lightfield/beam.h"
#include "lightfield/display.h"

namespace lamella {

struct Lens {
  int row = 0, column = 0;    // from the top and the left; negative ones lie beyond the panel
  double x_px = 0, y_px = 0;  // centre (hex_centre)
};

Lens LensOf(const LensletArray& lenses, int row, int column);
// The lens with the nearest centre (hex_assign; a hexagonal lattice's Voronoi cells are hexagons).
Lens NearestLens(const LensletArray& lenses, double x_px, double y_px);
// The ray of a pixel whose centre is so far right of (below) the window's: floor(offset + N/2);
// nothing outside [0, N).
std::optional<int> RayIndex(double offset_px, int rays);

// Slope dx/dz behind a plano-convex lens of thickness t and index n with the emitter on its flat
// side, `offset` from the vertex (lens_slope): -offset n/t for small angles, so that d0 = t/n, and
// by Snell's law.
double ParaxialLensSlope(double offset_mm, double thickness_mm, double index);
double ExactLensSlope(double offset_mm, double thickness_mm, double index);

// A lit pixel: its lens, and which of the lens's rays it is, from the left and from the top.
struct LensletPixel {
  Lens lens;
  int ray_column = 0, ray_row = 0;
};

class LensletMap {
 public:
  LensletMap(const Display& display, int layer);  // UsageError where the layer has no lenslets

  // Nothing for guard pixels, and under lenses that do not lie on the panel whole. With the
  // display's shear a lens's window is shifted by ShearShiftPx, as far as the pixels lie under it.
  std::optional<LensletPixel> Pixel(int column, int row) const;
  // The beam of a lit pixel, by its actual offset from the lens's centre. Of a hexagonal lens the
  // sides of the aperture are those of the brick of its area, pitch and row pitch.
  std::optional<Beam> BeamOf(int column, int row) const;
  // What the line through (x_mm, y_mm) on the modulating plane with slopes dx/dz, dy/dz meets;
  // nothing beside the panel and where no whole lens is. A steep line meets pixels of other lenses.
  std::optional<LayerHit> See(double x_mm, double y_mm, double slope_x, double slope_y) const;
  bool Whole(const Lens& lens) const;  // whether it lies on the panel whole

 private:
  double XFromPx(double x_px) const { return (x_px - columns_ / 2.0) * pitch_mm_; }
  double YFromPx(double y_px) const { return (rows_ / 2.0 - y_px) * pitch_mm_; }

  LensletArray lenses_;
  int columns_ = 0, rows_ = 0;
  double pitch_mm_ = 0, d0_mm_ = 0, power_per_mm_ = 0;
  double shear_distance_mm_ = 0;  // 0: no shear
};

}  // namespace lamella
