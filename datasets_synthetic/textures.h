// Procedural solid textures: colours of the points of a surface, seeded, without image files, and
// without detail finer than the ray that asks can carry.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

struct Texture {
  enum class Pattern {
    kNoise,  // clouds between two colours, veined with the third
    kSpots,  // round spots of the third colour at several sizes, on clouds
    kTiles,  // square tiles in the three colours, each of its own brightness, with fine noise
  };
  Pattern pattern = Pattern::kNoise;
  std::uint32_t seed = 1;
  double scale = 0.5;  // world units of the coarsest feature; a tile's side
  int octaves = 7;     // halvings of the scale
  Rgb dark{0.05F, 0.05F, 0.05F}, light{0.8F, 0.8F, 0.8F}, accent{0.6F, 0.2F, 0.1F};  // linear
};

// Reflectance at `point` (world units, from the surface's anchor), averaged in effect over
// `footprint` (world units, the side of the patch that a ray covers): each octave of noise is faded
// out before its finest detail gets smaller than two footprints, so that it can't alias.
Rgb ColorAt(const Texture& texture, const Eigen::Vector3d& point, double footprint);

// Gradient noise of unit lattice spacing in about [-1, 1] (Perlin, "Improving noise", 2002).
double GradientNoise(const Eigen::Vector3d& point, std::uint32_t seed);

}  // namespace lamella
