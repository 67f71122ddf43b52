// What the beams of a display's layers can carry of a scene, as an eye sees it: the picture without
// a display, blurred depth by depth, each as wide as the beams are there of the layers that show it
// (the section box(W_a) * box(W_b) of displays.md section 1.3, on both axes). Of a wave on a plane
// it keeps what that section's MTF leaves, S; between two layers the mean by their weights. The
// display itself leaves S^2, since its frames are averaged and then seen through beams again, and
// adds what its lattices and its additive layers make wrong: this is the bound that the prefilter
// sets, not a model of the display.
//
// Beams are taken for products of the axes. Barriers' are, and those of lenses on a square lattice.
// A hexagonal lens stands for the square one of the same second moments, sqrt(5/6) of its pitch
// wide: what they leave of waves below 1/(2 pitch) differs by less than 0.7 % of their contrast.
// Cylinder lenses, upright or slanted, are a lens by a sub-pixel along x, and along y a row as it
// is seen, at every depth: so has the prefilter them, row by row. Within its row the slice of a
// slanted lens leans, which the display alone knows of: of waves below the cut-off its own S
// differs by up to 0.06 on the layer and 0.2 at the ends of its range (4.5 sub-pixels, slant 1/6).
#pragma once

#include <vector>

#include "distribute/assign.h"
#include "distribute/simulate_eye.h"
#include "lightfield/beam.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// What an eye sees without a display; all of the eye's size.
struct SeenScene {
  Image<Rgb> light;  // linear, of what is known, times its coverage
  Image<float> z;    // mm, in the display's frame; -inf: infinitely far
  Image<float> coverage;
};

// A layer's part in the blur at the depths around a plane.
struct BlurPart {
  int plane = 0, layer = 0;
};

struct BandLimit {
  LayerWeights weights;
  std::vector<double> layers_mm;  // the modulating planes
  std::vector<Beam> beams;        // in the middle of each layer
  std::vector<double> planes_mm;  // BlurPlanes, and -inf before them
  std::vector<BlurPart> parts;    // by planes
};
BandLimit BandLimitOf(const Display& display);

// Before a pinhole eye in front of all planes; the mean of it over a pupil's points is what is
// carried to the pupil. Every pixel spreads over its neighbours as far as it is covered, and what
// they get is divided by how far they are covered by that: what is not known darkens nothing.
// Pixels of coverage 0 stay black, as they are on a display. A pixel whose colour is not finite
// counts as not known. Does not depend on the number of threads.
Image<Rgb> BandLimited(const SeenScene& scene, const BandLimit& limit, const Eye& eye);

}  // namespace lamella
