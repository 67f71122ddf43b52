// Where the area that a lens fills in a photograph has its middle.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calibration/screen_map.h"

namespace lamella {

// A lens, where a photograph shows it about, within a quarter of its width.
struct LensInPhoto {
  Eigen::Vector2d middle_px{0, 0};
  // What its innermost pixels show: real and imaginary parts of the sinusoids of all series. Empty
  // where these are dark or overexposed.
  Eigen::VectorXd light = {};
};

// As wide as `width_px` of the photograph.
LensInPhoto LensAt(const ScreenMap& map, const Eigen::Vector2d& middle_px, double width_px);

// Pixels on the seams between lenses see two to four of them. A pixel's sinusoids add as light
// does: they are those of the lenses, each by its share of the pixel. The middle is that of all
// pixels by their shares. Shares have the camera's blur in them, so that the sum over pixels is as
// good as the integral (what is left at a blur of s px is of exp(-2 pi^2 s^2) by Poisson's formula:
// 6e-5 at 0.7), where the middle of whole pixels beats with the grid of pixels by a tenth of one.
// Nothing where a pixel or a neighbour is dark or overexposed, where the photograph ends, or of
// more than 8 neighbours, which are those all around.
std::optional<Eigen::Vector2d> MiddleByShares(const ScreenMap& map, const LensInPhoto& lens,
                                              const std::vector<LensInPhoto>& neighbours);

}  // namespace lamella
