// Quads drawn into a raster of numbers, the largest wins: the inner loop of the forward warp.
#pragma once

#include <array>
#include <cstdint>

#include "depth/bundle_map.h"
#include "lightfield/image.h"

namespace lamella {

// Corners a b / c d of quads side by side: corner k of quad i is at (u[k][i], v[k][i]) with value
// n[k][i]. Readable up to kQuadPadding beyond the last quad.
struct Quads {
  std::array<const float*, 4> u, v, n;
  const std::uint8_t* drawn = nullptr;  // 0: leave the quad out
  int count = 0;
};
inline constexpr int kQuadPadding = 16;

// Vertices (da[i], db) with inverse depth w[i] through `map` (around inverse depth `at_w`) to
// (u[i], v[i]) with nearness n[i]; u is not a number where they are not in front. Reads and writes
// up to kQuadPadding beyond the last vertex.
void MapVertices(const LocalMap& map, float at_w, const float* da, float db, const float* w,
                 int count, float* u, float* v, float* n);

// Each quad is the two triangles a b c and d c b. A raster point (i + 0.5, j + 0.5) that a triangle
// covers takes the triangle's value there (linear) where that is finite and larger than its own.
// Triangles that run the other way round (seen from behind), or are degenerate or not finite, draw
// nothing. They reach a thousandth beyond their edges, so that rounding leaves no cracks.
void DrawQuads(const Quads& quads, ImageSpan<float> raster);

}  // namespace lamella
