// Forward warp: a view's depth drawn into the rays of a bundle.
#pragma once

#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include "depth/source_view.h"
#include "lightfield/image.h"

namespace lamella {

inline constexpr float kNoSurface = -std::numeric_limits<float>::infinity();

// Tiles of a bundle in which a view is wanted: wanted(x, y) != 0 for rays
// [x * size, (x + 1) * size) x [y * size, (y + 1) * size).
struct TileMask {
  int size = 32;  // rays
  ImageSpan<const std::uint8_t> wanted;
};

// Draws the surface of `level` into `nearness` (one value a ray, see bundle_map.h): every ray takes
// the largest of what it had and what hits it. Smooth cells are drawn as two triangles, which is
// exact for planes and leaves no cracks however fine the rays are; quarters of broken cells keep
// their pixel's depth. Surfaces seen from behind are left out. `bundle_from_level`: (x, y, 1, 1/Z)
// of the level's pixels to (u, v, 1, n). Outside of wanted tiles rays may be drawn or not.
void DrawSurface(const DepthLevel& level, const Eigen::Matrix4d& bundle_from_level,
                 const TileMask& tiles, ImageSpan<float> nearness);

// Fills rays without a surface with the farther of their nearest neighbours in the four directions
// along rows and columns (a disocclusion belongs to the background), then with `otherwise`.
void FillFromFartherSide(float otherwise, ImageSpan<float> nearness);

}  // namespace lamella
