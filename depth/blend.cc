#include "depth/blend.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace lamella {
namespace {

// A view fades in over this share of its smaller side.
constexpr double kFade = 0.02;
// Coverage is whole from this visibility on: a surface seen twice is never quite at one depth.
constexpr float kWhollySeen = 0.5F;

Rect TileOf(const Rect& rays) {
  return {rays.x / kTile * kTile, rays.y / kTile * kTile, kTile, kTile};
}

void FillRays(const Rect& rays, ImageSpan<const float> nearness, TileRays& tile) {
  const Rect whole = TileOf(rays);
  tile.count = rays.width * rays.height;
  std::size_t i = 0;
  for (int y = 0; y < rays.height; ++y) {
    const float dv = static_cast<float>(rays.y - whole.y + y) + 0.5F - 0.5F * kTile;
    for (int x = 0; x < rays.width; ++x, ++i) {
      tile.du[i] = static_cast<float>(rays.x - whole.x + x) + 0.5F - 0.5F * kTile;
      tile.dv[i] = dv;
      tile.nearness[i] = nearness(x, y);
    }
  }
  const std::size_t padded = i + kRayPadding;
  for (std::size_t k = i; k < padded; ++k) tile.du[k] = tile.dv[k] = tile.nearness[k] = 0;
  for (PerRay<float>* sums : {&tile.weight, &tile.seen, &tile.most_seen, &tile.confidence}) {
    std::fill_n(sums->begin(), padded, 0.0F);
  }
  std::fill_n(tile.color.begin(), padded, ColorLevel::Sum());
}

TileView ViewOfTile(const BundleGeometry& geometry, const SourceView& view, const Sight& sight,
                    double neighbour, const Rect& tile, float nearness) {
  TileView result{LocalMap(view.view_from_world * geometry.world_from_bundle(),
                           tile.x + 0.5 * kTile, tile.y + 0.5 * kTile,
                           static_cast<double>(nearness))};
  result.at_nearness = nearness;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t right = i % 2, below = i / 2;
    const double u = tile.x + static_cast<double>(right) * kTile;
    const double v = tile.y + static_cast<double>(below) * kTile;
    const double offset =
        std::sqrt(geometry.DistanceSquared(u, v, view.centre)) / neighbour + sight.resolution;
    result.penalty[i] = static_cast<float>(std::min(offset * offset, 1e12));
  }
  result.width = static_cast<float>(view.width);
  result.height = static_cast<float>(view.height);
  result.per_fade =
      static_cast<float>(1 / std::max(1.0, kFade * std::min(view.width, view.height)));
  result.softness_absolute = static_cast<float>(view.softness_absolute);
  result.softness_relative = static_cast<float>(view.softness_relative);
  const double spacing = sight.spacing * geometry.bundle().footprint;
  result.depth = &DepthLevelForSpacing(view, spacing);
  result.color = &ColorLevelForSpacing(view, spacing);
  return result;
}

RaySample Sample(const TileRays& tile, std::size_t i, float per_color_scale) {
  RaySample sample;
  const float weight = tile.weight[i];
  if (!(weight > 0)) return sample;
  const float scale = per_color_scale / weight;
  const float* sum = tile.color[i].channels;
  sample.color = {scale * sum[0], scale * sum[1], scale * sum[2]};
  sample.coverage = std::min(1.0F, tile.most_seen[i] / kWhollySeen);
  sample.confidence = std::min(1.0F, tile.confidence[i] / weight);
  return sample;
}

}  // namespace

void BlendTile(const BundleGeometry& geometry, const std::vector<SourceView>& views,
               const TileSights& sights, double neighbour, const BlendOptions& options,
               const Rect& rays, ImageSpan<const float> nearness, ImageSpan<RaySample> samples) {
  TileRays tile;
  ActiveRays active;
  FillRays(rays, nearness, tile);
  for (std::size_t k = 0; k < sights.sights.size(); ++k) {
    const Sight& sight = sights.sights[k];
    const TileView view = ViewOfTile(geometry, views[static_cast<std::size_t>(sight.view)], sight,
                                     neighbour, TileOf(rays), sights.nearness);
    SeeTile(view, k >= static_cast<std::size_t>(options.views), tile, active);
    AddColors(*view.color, options.cubic, active, tile);
  }
  const DistanceFromNearness distance(geometry.bundle(), geometry.zero());
  const float per_color_scale = 1.0F / options.color_scale;
  std::size_t i = 0;
  for (int y = 0; y < rays.height; ++y) {
    for (int x = 0; x < rays.width; ++x, ++i) {
      samples(x, y) = Sample(tile, i, per_color_scale);
      samples(x, y).z = distance(nearness(x, y));
    }
  }
}

}  // namespace lamella
