// What a display can show, from its numbers alone: cut-off and MTF over depth, rays, angles, light,
// eye box (ranieri2012.md section 5; displays.md sections 1.3 to 3; simulation.md section 5). All
// lengths are mm as the viewer sees them, frequencies cycles per mm in the content's own plane.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lightfield/beam.h"
#include "lightfield/display.h"

namespace lamella {

// From -x_mm to x_mm and -y_mm to y_mm in the plane z = D; +inf where any height will do.
struct EyeRectangle {
  double x_mm = 0, y_mm = 0;
};

// Where an eye sees, through every part of every element, an emitter of that element's own window
// (simulation.md section 5, which takes D for D - z):
//   |e| <= ((fan - |1 - d0/f| w_x)/2 - p/2) (D - z)/d0,   p/2 for the shear's rounding.
// Without shear all fans are parallel, and half of the panel's width goes off instead of p/2.
// Lenses show what is under themselves only, so for them |e| + half of the panel is bounded by the
// lens's width, too (lenticular lenses along x: and by how far the slant shifts them over the
// panel's height). 0 where there is no such place. A bare panel's is the eye box that it is made
// for.
EyeRectangle CleanEyeBoxOf(const Display& display, const Layer& layer);

// The widths of a layer's beams along a row: of an element and an emitter in the middle.
AxisBeam MiddleBeam(const Display& display, const Layer& layer);
// And along both axes. Cylinder lenses have no parallax along a column: at every depth it is an
// emitter's height as it is seen there from (0, 0, D), or from afar without shear. Hexagonal lenses
// are taken for squares as wide.
Beam MiddleBeams(const Display& display, const Layer& layer);

// Emitters that are lit, times the slots in which each has a direction of its own. Elements that
// the panel's edge cuts are counted by their area. Of lenticular lenses: sub-pixels.
double RaysOf(const Display& display, const Layer& layer);

struct LayerFigures {
  double position_mm = 0, d0_mm = 0;
  double lattice_pitch_mm = 0, direction_step_mm = 0;  // Delta x, Delta u
  double sharp_range_mm = 0;                           // z_max
  double sharpest_mm = 0;                              // z where its beam is narrowest
  double field_of_view_deg = 0;
  int directions_per_axis = 0;
  double view_spacing_mm = 0;   // at the viewer
  double light_efficiency = 0;  // Brightness()
  double guard_share = 0;
  double rays = 0;
  EyeRectangle clean_eye_box;
};

// What a display costs and gives in all.
struct DisplayTotals {
  double rays = 0;  // of all layers
  // That its emissive panels show of one picture: pixels x 3 channels x 8 bits x slots of every
  // layer, or pixels x planes x strokes where the planes are of one bit. Modulators' patterns,
  // which are the same for every picture, are not counted.
  double bits = 0;
  double light_efficiency = 0;  // Brightness(), mean over the layers
};
// `strokes` of one-bit planes; without, pixels have colours.
DisplayTotals TotalsOf(const Display& display, const std::optional<int>& strokes);

struct DepthInterval {
  double from_mm = 0, to_mm = 0;
  bool Contains(double z_mm) const { return from_mm <= z_mm && z_mm <= to_mm; }
};

// Rows of displays.md section 1.3, [frequency][depth]. A depth in the border of two layers, which
// both show it, has the mean by their weights.
struct MtfRows {
  std::vector<std::vector<double>> single;  // S: the prefilter alone, and the display alone
  std::vector<std::vector<double>> both;    // S^2: prefilter and display, mean over views
  // Prefilter and display before one far eye; empty for optics without a closed form of it
  // (pinholes and lenses out of focus: single views differ, their mean is `both`).
  std::vector<std::vector<double>> fixed_eye;
};

struct Analysis {
  int parallax_axes = 2;
  std::vector<LayerFigures> layers;
  DisplayTotals totals;
  EyeRectangle clean_eye_box;  // of all layers
  // Depths that a layer shows at the full resolution of its lattice, by Eq. 1; disjoint, rising.
  std::vector<DepthInterval> sharp;
  // Rays relative to one layer of the same lattice and field of view that has the same range:
  // n (z_max / half range)^a, which is n^(1-a) where the layers share the range evenly. Nothing
  // where the layers differ or leave gaps.
  std::optional<double> rays_to_one_layer;

  std::vector<double> depths_mm;            // rising
  std::vector<std::vector<double>> cutoff;  // [layer][depth], Eq. 1
  std::vector<double> combined;             // the best layer's
  std::vector<double> combined_beam;        // the best layer's by the beam's real widths
  std::vector<double> frequencies;          // a quarter, a half and all of the finest lattice's
  MtfRows mtf;                              // of the display's own beams
  MtfRows paper_mtf;  // of lens beams with w_x = Delta x, w_u = Delta u: the paper's box
};

// The depths that are worth a look: what the layers show sharply, and half as much beside it, as
// far as it lies well before the viewer.
DepthInterval DepthsWorthALook(const Display& display);

// Over these depths: equal steps and the places where a curve bends. UsageError where the display
// can't work. `strokes` as of TotalsOf.
Analysis Analyze(const Display& display, const DepthInterval& depths,
                 const std::optional<int>& strokes = {});

// The best layer's cut-off at a depth, Eq. 1, and that of its beams' real widths; -inf allowed.
double CombinedCutoffPerMm(const Display& display, double z_mm);
double CombinedBeamCutoffPerMm(const Display& display, double z_mm);

}  // namespace lamella
