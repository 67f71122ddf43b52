// Procedural solid textures: colours of the points of a surface, seeded, without image files, and
// without detail finer than the ray that asks can carry.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

struct Texture {
  enum class Pattern {
    kNoise,    // clouds between two colours, veined with the third
    kSpots,    // round spots of the third colour at several sizes, on clouds
    kTiles,    // square tiles in the three colours, each of its own brightness, with fine noise
    kPlain,    // light everywhere
    kGrating,  // (1 + sin(2 pi frequency s)) / 2 of the way from dark to light, s along direction
    kChecker,  // cubes of side `scale` in dark and light, light about the anchor; flat surfaces
               // have squares that begin with a light one at their corner
  };
  Pattern pattern = Pattern::kNoise;
  std::uint32_t seed = 1;
  double scale = 0.5;  // world units of the coarsest feature; a tile's or square's side
  int octaves = 7;     // halvings of the scale
  Rgb dark{0.05F, 0.05F, 0.05F}, light{0.8F, 0.8F, 0.8F}, accent{0.6F, 0.2F, 0.1F};  // linear
  Eigen::Vector3d direction{1, 0, 0};  // of a grating, any length but 0
  double frequency = 1;                // of a grating, cycles per world unit
};

// Reflectance at `point` (world units, from the surface's anchor), averaged in effect over
// `footprint` (world units, the side of the patch that a ray covers): each octave of noise is faded
// out before its finest detail gets smaller than two footprints, so that it can't alias. Gratings
// and checkers are averaged exactly, over a box; it has no extent along `normal` (unit, or 0 for
// a cube), so that on a flat surface it is the patch.
Rgb ColorAt(const Texture& texture, const Eigen::Vector3d& point, double footprint,
            const Eigen::Vector3d& normal = Eigen::Vector3d::Zero());

// Gradient noise of unit lattice spacing in about [-1, 1] (Perlin, "Improving noise", 2002).
double GradientNoise(const Eigen::Vector3d& point, std::uint32_t seed);

}  // namespace lamella
