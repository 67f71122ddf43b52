// Forward warp: a view's depth drawn into the rays of a bundle.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "depth/source_view.h"
#include "lightfield/image.h"

namespace lamella {

inline constexpr float kNoSurface = -std::numeric_limits<float>::infinity();

// A square of a level's cells (DepthLevel::blocks) and the box of rays that its surface can hit,
// cut to the bundle.
struct LandingBlock {
  int x = 0, y = 0;
  float u0 = 0, u1 = 0, v0 = 0, v1 = 0;
};
// Those that can hit a ray of a bundle of this size. `bundle_from_level`: (x, y, 1, 1/Z) of the
// level's pixels to (u, v, 1, n), as for DrawBlocks.
std::vector<LandingBlock> LandingBlocks(const DepthLevel& level,
                                        const Eigen::Matrix4d& bundle_from_level, int width,
                                        int height);

// Draws the blocks' surface into `nearness` (one value a ray, see bundle_map.h): every ray takes
// the largest of what it had and what hits it. Smooth cells are drawn as two triangles, which is
// exact for planes and leaves no cracks however fine the rays are; quarters of broken cells keep
// their pixel's depth. Surfaces seen from behind are left out.
void DrawBlocks(const DepthLevel& level, const Eigen::Matrix4d& bundle_from_level,
                std::span<const LandingBlock> blocks, ImageSpan<float> nearness);

// Fills rays without a surface with the farther of their nearest neighbours in the four directions
// along rows and, at most `reach` rays away, columns (a disocclusion belongs to the background),
// then with `otherwise`.
void FillFromFartherSide(float otherwise, int reach, ImageSpan<float> nearness);

}  // namespace lamella
