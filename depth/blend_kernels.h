// The inner loops of blending: where a tile's rays are in a view and whether it sees them, and
// their colours there. Lanes are rays; no fused multiply-add, so that every target gives the same
// bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "depth/bundle_map.h"
#include "depth/source_view.h"

namespace lamella {

// Rays are blended in tiles of this side, laid out from the bundle's first ray.
inline constexpr int kTile = 32;
inline constexpr std::size_t kTileRays = static_cast<std::size_t>(kTile) * kTile;
inline constexpr std::size_t kRayPadding = 16;  // kernels read and write so far beyond the last ray

template <class T>
using PerRay = std::array<T, kTileRays + kRayPadding>;

// The rays of a tile, one after the other, and what the views so far gave them.
struct TileRays {
  int count = 0;
  PerRay<float> du, dv;  // from the tile's middle, rays
  PerRay<float> nearness;
  PerRay<float> weight;           // sum of the views' weights
  PerRay<float> seen;             // sum of visibilities
  PerRay<float> most_seen;        // the largest
  PerRay<float> confidence;       // sum of weight * confidence of the views that see the ray
  PerRay<ColorLevel::Sum> color;  // sum of weight * colour
};

// A view, as a tile's rays meet it.
struct TileView {
  LocalMap view_from_tile;  // around the tile's middle at `at_nearness`
  float at_nearness = 0;
  std::array<float, 4> penalty{};  // squared, at the tile's corners (upper left, right, lower ...)
  float width = 0, height = 0;     // of the picture, px
  float per_fade = 1;              // 1 / px over which the picture fades in
  float softness_absolute = 0, softness_relative = 0;
  const DepthLevel* depth = nullptr;
  const ColorLevel* color = nullptr;
};

// Rays that a view gives colour to.
struct ActiveRays {
  int count = 0;
  PerRay<std::int32_t> ray;
  PerRay<float> x, y, weight;  // picture px
};

// Adds the view's part to weight, seen, most_seen and confidence of all rays, or of those only that
// no view has seen yet, and lists the rays whose colour it changes.
//   weight = share / (kOwnView + penalty),
//   share = fade * (visible + a little), visible = about exp(-q^2 / 2), q = (inverse depth of the
//   view's surface there - the ray's) / softness
// Beside an edge of depth the nearest of the four pixels is the view's surface: what lies behind it
// may be hidden or mixed.
void SeeTile(const TileView& view, bool unseen_only, TileRays& rays, ActiveRays& active);

// Adds weight * colour of each active ray; Catmull-Rom or bilinear, cut at black.
void AddColors(const ColorLevel& level, bool cubic, const ActiveRays& active, TileRays& rays);

}  // namespace lamella
