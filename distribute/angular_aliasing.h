// Angular aliasing: what is wrong with an eye's picture and changes when the eye moves a little, as
// too few or unfiltered directions make it shimmer (ranieri2012.md section 8, experiment 6).
//
//   10 log10(mean (e_b(p) - e_a(p))^2 / mean t_a(p)^2),   e = seen - target
//
// over the pixels p of an eye a, t its target. Eye b stands beside it, and e_b is that of the scene
// point that a sees at p: what moves with the scene's parallax, such as missing contrast, is no
// aliasing.
#pragma once

#include <optional>

#include "distribute/simulate_eye.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// Luminance, linear light; all of the eye's size.
struct SeenAgainstTarget {
  Eye eye;
  Image<float> seen, target;
  Image<float> z;      // of the scene, mm; -inf: infinitely far
  Image<float> known;  // pixels of 1/2 and more count
};

// From an eye to the one beside it: a quarter of the layers' least spacing of views.
double AliasingStepMm(const Display& display);

// dB; -inf where nothing changes, nothing where no pixel counts. The eyes differ in x alone.
// Left out are `border_px` on all sides and points that b does not see, by its depths there.
std::optional<double> AngularAliasing(const SeenAgainstTarget& a, const SeenAgainstTarget& b,
                                      int border_px);

}  // namespace lamella
