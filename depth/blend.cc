#include "depth/blend.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace lamella {
namespace {

// A view fades in over this share of its smaller side.
constexpr double kFade = 0.02;
// Coverage is whole from this visibility on: a surface seen twice is never quite at one depth.
constexpr float kWhollySeen = 0.5F;
// Less than this of all views' weight is not worth a lookup.
constexpr float kNegligible = 1e-3F;
// Surfaces so many softnesses from a point do not show it (SeeTile: 2.83), and so many depth pixels
// are added to a box for what rounding may do.
constexpr double kHiddenSoftness = 3, kSlackPx = 0.5;

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

// Picture pixels and inverse depths.
struct ViewBox {
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300, w0 = 1e300, w1 = -1e300;
};

// Where a tile's rays can be in a view; nothing where some of them may be behind it.
std::optional<ViewBox> BoxOfTile(const Eigen::Matrix4d& view_from_bundle, const Rect& tile,
                                 const TileSights& sights) {
  ViewBox box;
  for (int corner = 0; corner < 8; ++corner) {
    const double u = tile.x + corner % 2 * kTile, v = tile.y + corner / 2 % 2 * kTile;
    const double n = static_cast<double>(corner / 4 == 0 ? sights.far : sights.near);
    const Eigen::Vector4d out = view_from_bundle * Eigen::Vector4d(u, v, 1, n);
    if (!(out.z() > 0)) return std::nullopt;
    const double x = out.x() / out.z(), y = out.y() / out.z(), w = out.w() / out.z();
    box.x0 = std::min(box.x0, x), box.x1 = std::max(box.x1, x);
    box.y0 = std::min(box.y0, y), box.y1 = std::max(box.y1, y);
    box.w0 = std::min(box.w0, w), box.w1 = std::max(box.w1, w);
  }
  return box;
}

// False where the view certainly sees none of a tile's rays: they are outside of its picture, or
// its depth is unknown or another one all over there.
bool MaySee(const SourceView& view, const DepthLevel& level,
            const Eigen::Matrix4d& view_from_bundle, const Rect& tile, const TileSights& sights) {
  const std::optional<ViewBox> box = BoxOfTile(view_from_bundle, tile, sights);
  if (!box) return true;
  const auto cell = [](double at, double per_color, double slack, int count) {
    return static_cast<int>(std::clamp(at * per_color + 0.5 + slack, 0.0, count * 1.0));
  };
  if (!(box->x1 >= -kSlackPx && box->y1 >= -kSlackPx && box->x0 <= view.width + kSlackPx &&
        box->y0 <= view.height + kSlackPx)) {
    return false;
  }
  const double reach =
      kHiddenSoftness * (view.softness_absolute + view.softness_relative * std::max(box->w1, 0.0));
  constexpr int kBlock = DepthLevel::kBlock;
  const int x0 = cell(box->x0, level.per_color_x, -kSlackPx, level.width) / kBlock;
  const int x1 = cell(box->x1, level.per_color_x, kSlackPx, level.width) / kBlock;
  const int y0 = cell(box->y0, level.per_color_y, -kSlackPx, level.height) / kBlock;
  const int y1 = cell(box->y1, level.per_color_y, kSlackPx, level.height) / kBlock;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const DepthLevel::Block& block = level.blocks(x, y);
      if (block.nearest >= 0 && static_cast<double>(block.nearest) >= box->w0 - reach &&
          static_cast<double>(block.farthest) <= box->w1 + reach) {
        return true;
      }
    }
  }
  return false;
}

TileView ViewOfTile(const BundleGeometry& geometry, const SourceView& view,
                    const Eigen::Matrix4d& view_from_bundle, const Sight& sight, double neighbour,
                    const Rect& tile, float nearness) {
  TileView result{LocalMap(view_from_bundle, tile.x + 0.5 * kTile, tile.y + 0.5 * kTile,
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
  return result;
}

// Leaves out what is negligible beside all views together, and all of rays that no view sees where
// nothing is guessed.
void KeepUseful(bool guess, TileRays& tile, ActiveRays& active) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(active.count); ++i) {
    const auto ray = static_cast<std::size_t>(active.ray[i]);
    const float weight = active.weight[i];
    const bool useful = weight > kNegligible * tile.weight[ray];
    if (!useful) tile.weight[ray] -= weight;
    active.ray[kept] = active.ray[i];
    active.x[kept] = active.x[i];
    active.y[kept] = active.y[i];
    active.weight[kept] = weight;
    kept += useful && (guess || tile.most_seen[ray] > 0) ? 1 : 0;
  }
  active.count = static_cast<int>(kept);
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
  FillRays(rays, nearness, tile);
  struct Looked {
    const ColorLevel* color = nullptr;
    ActiveRays active;
  };
  // Not initialised: what counts is written.
  const auto looked = std::make_unique_for_overwrite<Looked[]>(sights.sights.size());
  std::size_t count = 0;
  for (std::size_t k = 0; k < sights.sights.size(); ++k) {
    const Sight& sight = sights.sights[k];
    const SourceView& from = views[static_cast<std::size_t>(sight.view)];
    const Eigen::Matrix4d view_from_bundle = from.view_from_world * geometry.world_from_bundle();
    const double spacing = sight.spacing * geometry.bundle().footprint;
    const DepthLevel& depth = DepthLevelForSpacing(from, spacing);
    if (!options.guess && !MaySee(from, depth, view_from_bundle, TileOf(rays), sights)) continue;
    TileView view = ViewOfTile(geometry, from, view_from_bundle, sight, neighbour, TileOf(rays),
                               sights.nearness);
    view.depth = &depth;
    view.color = &ColorLevelForSpacing(from, spacing);
    looked[count].color = view.color;
    SeeTile(view, k >= static_cast<std::size_t>(options.views), tile, looked[count].active);
    ++count;
  }
  for (std::size_t k = 0; k < count; ++k) {
    KeepUseful(options.guess, tile, looked[k].active);
    AddColors(*looked[k].color, options.cubic, looked[k].active, tile);
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
