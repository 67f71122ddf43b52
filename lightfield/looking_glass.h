// The view of every sub-pixel of a Looking Glass display from its calibration, the numbers of
// visual.json (displays.md section 4, where they are explained and published sources are named).
#pragma once

#include <array>
#include <vector>

namespace lamella {

struct LookingGlass {
  // Offsets of the sub-pixels R, G, B from the pixel's centre, px: x right, y up.
  using Cell = std::array<std::array<double, 2>, 3>;

  double pitch_per_in = 0;  // lenses per inch, across them
  double slope = 0;         // the lenses run along (-1, slope), y up
  double center = 0;        // phase, in lenses
  double dpi = 0;
  int width_px = 0, height_px = 0;
  bool flip_x = false;          // mirrors the picture and the lenses' lean
  bool flip_y = false;          // mirrors the picture
  bool flip_subpixels = false;  // stripes B, G, R; cells name their colours themselves
  // False: of the first generation's calibrations, whose views run the other way.
  bool invert_views = true;
  int cell_pattern = 0;     // CellPatternMode: which cell a pixel has
  std::vector<Cell> cells;  // none: stripes
};

// What renderers make of it (lkg_processed).
struct LookingGlassWeave {
  double lenses = 0;    // across the screen's width, along a row
  double tilt = 0;      // of the lenses, in screens
  double subpixel = 0;  // a stripe's width, in screens
};
LookingGlassWeave WeaveOf(const LookingGlass& calibration);

// The view that a sub-pixel belongs to, in [0, 1]: 0 is the leftmost camera (lkg_view). `row`
// counts from the top.
double LookingGlassView(const LookingGlass& calibration, int column, int row, int channel);
// The same where `weave`, WeaveOf(calibration), is known.
double LookingGlassView(const LookingGlass& calibration, const LookingGlassWeave& weave, int column,
                        int row, int channel);
// Of `views`, numbered from the leftmost.
int ViewIndex(double view, int views);

}  // namespace lamella
