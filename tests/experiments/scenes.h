// Scenes in closed form that do not change along y, so that only the first row of a bundle has to
// be asked; for the rest tests/reference/analytic_scene.h.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "lightfield/ray_source.h"

namespace lamella::experiments {

// What is seen along the line x = x0 + slope z: grey radiance, and where.
struct Seen {
  double radiance = 0;
  double z = -std::numeric_limits<double>::infinity();
};

class SceneAlongX final : public RaySource {
 public:
  using Trace = std::function<Seen(double x0, double slope)>;
  explicit SceneAlongX(Trace trace) : trace_(std::move(trace)) {}

  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override;

 private:
  Trace trace_;
};

// A plane at z with 1/2 + the sum of cos(2 pi f x): content for complex amplitudes, of any range.
SceneAlongX PlaneOfWaves(double z, std::vector<double> frequencies);

// A texture of many waves with random phases, 1/f, from 0.02 to 0.8 cycles/mm, mean 0.5 and
// standard deviation 0.16, as a function of x, or of x and y (from a table of 38.4 x 38.4 mm, again
// and again).
std::function<double(double)> TextureAlongX(unsigned seed);
std::function<double(double, double)> Texture(unsigned seed);

}  // namespace lamella::experiments
