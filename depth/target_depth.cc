#include "depth/target_depth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "depth/blend.h"
#include "depth/forward_warp.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Rows of tiles that are merged together: few, so that their rays stay in cache and threads have
// something to do; not one, since each band draws the squares at its border again.
constexpr int kBandTiles = 3;
// Surfaces of several maps at one ray are one where they differ by less than this many softnesses
// of the visibility test.
constexpr double kSameSurface = 0.6;
// Weight of a map by its direction, as in blending.
constexpr double kOwnView = 0.02;
// Rows of tiles above and below in which a hole's neighbours are looked for.
constexpr int kFillTiles = 2;

int Tiles(int rays) { return (rays + kTile - 1) / kTile; }

// A map that a tile wants, at which place in the tile's list.
struct Wish {
  int tile_x = 0, tile_y = 0, rank = 0;
  float weight = 0, tolerance = 0;
};

// For every view the tiles that want its map.
using Wishes = std::vector<std::vector<Wish>>;

// How much nearness changes per inverse depth of a view, at (u, v, n).
double NearnessPerInverseDepth(const BundleGeometry& geometry, const SourceView& view, double u,
                               double v, double n, double* inverse_depth) {
  const Eigen::Matrix4d map = view.view_from_world * geometry.world_from_bundle();
  const Eigen::Vector4d out = map * Eigen::Vector4d(u, v, 1, n);
  *inverse_depth = out.w() / out.z();
  const double slope = (map(3, 3) - *inverse_depth * map(2, 3)) / out.z();
  return slope != 0 ? std::abs(1 / slope) : 0;
}

Wishes CollectWishes(const BundleGeometry& geometry, const std::vector<SourceView>& views,
                     const NearnessRange& range, const ViewRanking& ranking,
                     const TargetDepthOptions& options, int first_tile_row, int end_tile_row) {
  Wishes wishes(views.size());
  const RayBundle& bundle = geometry.bundle();
  for (int ty = first_tile_row; ty < end_tile_row; ++ty) {
    for (int tx = 0; tx < Tiles(bundle.width); ++tx) {
      const double u = std::min((tx + 0.5) * kTile, tx * kTile + 0.5 * (bundle.width - tx * kTile));
      const double v =
          std::min((ty + 0.5) * kTile, ty * kTile + 0.5 * (bundle.height - ty * kTile));
      const auto sights =
          ranking.Best(u, v, {range.middle, range.far, range.near}, options.maps + options.further);
      for (std::size_t rank = 0; rank < sights.size(); ++rank) {
        const auto k = static_cast<std::size_t>(sights[rank].view);
        double w = 0;
        const double slope = NearnessPerInverseDepth(geometry, views[k], u, v, range.middle, &w);
        const double softness =
            views[k].softness_absolute + views[k].softness_relative * std::max(w, 0.0);
        const double penalty = std::min(sights[rank].penalty, 1e6);
        wishes[k].push_back({tx, ty, static_cast<int>(rank),
                             static_cast<float>(1 / (kOwnView + penalty * penalty)),
                             static_cast<float>(kSameSurface * softness * slope)});
      }
    }
  }
  return wishes;
}

// A view's surface as a bundle meets it.
struct Landing {
  const DepthLevel* level = nullptr;
  Eigen::Matrix4d bundle_from_level;
  std::vector<LandingBlock> blocks;
};

Landing LandingOf(const BundleGeometry& geometry, const SourceView& view, const DepthLevel& level) {
  Eigen::Matrix4d level_from_world = view.view_from_world;
  level_from_world.row(0) *= level.per_color_x;
  level_from_world.row(1) *= level.per_color_y;
  Landing landing{&level, geometry.bundle_from_world() * level_from_world.inverse(), {}};
  const RayBundle& bundle = geometry.bundle();
  landing.blocks = LandingBlocks(level, landing.bundle_from_level, bundle.width, bundle.height);
  return landing;
}

// A band of rows of the bundle with what the maps merged so far say.
class Band {
 public:
  Band(int first_tile_row, ImageSpan<float> nearness)
      : first_tile_row_(first_tile_row),
        nearness_(nearness),
        weights_(nearness.width, nearness.height),
        drawn_(nearness.width, nearness.height),
        tiles_(Tiles(nearness.width), Tiles(nearness.height)),
        merged_(tiles_.width(), tiles_.height()) {
    for (int y = 0; y < nearness.height; ++y) {
      std::fill_n(nearness.row(y), nearness.width, kNoSurface);
    }
  }

  // Merges a view's map into the tiles that want it at the given ranks.
  void Merge(const Landing& view, const std::vector<Wish>& wishes, int first_rank, int last_rank,
             bool holes_only) {
    std::vector<const Wish*> wanted, here;
    std::fill_n(tiles_.data(), tiles_.size(), Tile::kUnwanted);
    for (const Wish& wish : wishes) {
      const int row = wish.tile_y - first_tile_row_;
      if (row < 0 || row >= tiles_.height() || wish.rank < first_rank || wish.rank > last_rank)
        continue;
      if (holes_only && !HasHole(TileRays(wish))) continue;
      tiles_(wish.tile_x, row) = Tile::kWanted;
      wanted.push_back(&wish);
    }
    if (wanted.empty()) return;
    const std::vector<LandingBlock> blocks = Hit(view.blocks);
    for (const Wish* wish : wanted) {
      if (tiles_(wish->tile_x, wish->tile_y - first_tile_row_) == Tile::kHit) here.push_back(wish);
    }
    for (const Wish* wish : here) Clear(TileRays(*wish));
    Draw(view, blocks);
    for (const Wish* wish : here) {
      std::uint8_t& merged = merged_(wish->tile_x, wish->tile_y - first_tile_row_);
      if (holes_only) {
        FillHoles(TileRays(*wish));
      } else if (merged == 0) {
        TakeTile(*wish, TileRays(*wish));
        merged = 1;
      } else {
        MergeTile(*wish, TileRays(*wish));
      }
    }
  }

 private:
  enum class Tile : std::uint8_t { kUnwanted, kWanted, kHit };

  // The blocks that can hit wanted tiles, which are marked.
  std::vector<LandingBlock> Hit(const std::vector<LandingBlock>& blocks) {
    std::vector<LandingBlock> hit;
    const auto tile = [](float at) { return static_cast<int>(at) / kTile; };
    for (const LandingBlock& block : blocks) {
      bool wanted = false;
      const int y0 = std::max(tile(block.v0) - first_tile_row_, 0);
      const int y1 = std::min(tile(block.v1) - first_tile_row_, tiles_.height() - 1);
      const int x1 = std::min(tile(block.u1), tiles_.width() - 1);
      for (int y = y0; y <= y1; ++y) {
        for (int x = tile(block.u0); x <= x1; ++x) {
          if (tiles_(x, y) == Tile::kUnwanted) continue;
          tiles_(x, y) = Tile::kHit;
          wanted = true;
        }
      }
      if (wanted) hit.push_back(block);
    }
    return hit;
  }

  Rect TileRays(const Wish& wish) const {
    const int x = wish.tile_x * kTile, y = (wish.tile_y - first_tile_row_) * kTile;
    return {x, y, std::min(kTile, nearness_.width - x), std::min(kTile, nearness_.height - y)};
  }

  bool HasHole(const Rect& r) const {
    for (int y = r.y; y < r.y + r.height; ++y) {
      const float* row = nearness_.row(y);
      if (std::find(row + r.x, row + r.x + r.width, kNoSurface) != row + r.x + r.width) return true;
    }
    return false;
  }

  void Clear(const Rect& r) {
    for (int y = r.y; y < r.y + r.height; ++y)
      std::fill_n(drawn_.row(y) + r.x, r.width, kNoSurface);
  }

  void Draw(const Landing& view, const std::vector<LandingBlock>& blocks) {
    // To rows that count from the band's first.
    Eigen::Matrix4d map = view.bundle_from_level;
    map.row(1) -= static_cast<double>(first_tile_row_) * kTile * map.row(2);
    DrawBlocks(*view.level, map, blocks, drawn_.span());
  }

  // Of the first map there is nothing to merge with.
  void TakeTile(const Wish& wish, const Rect& r) {
    for (int y = r.y; y < r.y + r.height; ++y) {
      std::copy_n(drawn_.row(y) + r.x, r.width, nearness_.row(y) + r.x);
      std::fill_n(weights_.row(y) + r.x, r.width, wish.weight);
    }
  }

  // The nearest surface wins; what lies within the tolerance of it is averaged.
  void MergeTile(const Wish& wish, const Rect& r) {
    for (int y = r.y; y < r.y + r.height; ++y) {
      const float* from = drawn_.row(y);
      float* to = nearness_.row(y);
      float* weights = weights_.row(y);
      // Written without branches, for vector lanes.
      for (int x = r.x; x < r.x + r.width; ++x) {
        const float n = from[x], before = to[x], sum = weights[x] + wish.weight;
        const float mean = before + wish.weight / sum * (n - before);
        const bool nearer = n > before + wish.tolerance;
        const bool same =
            n >= before - wish.tolerance;  // both may be kNoSurface: mean is no number
        to[x] = nearer || n == before ? n : same ? mean : before;
        weights[x] = nearer ? wish.weight : same ? sum : weights[x];
      }
    }
  }

  void FillHoles(const Rect& r) {
    for (int y = r.y; y < r.y + r.height; ++y) {
      const float* from = drawn_.row(y);
      float* to = nearness_.row(y);
      for (int x = r.x; x < r.x + r.width; ++x) {
        if (to[x] == kNoSurface) to[x] = from[x];
      }
    }
  }

  int first_tile_row_;
  ImageSpan<float> nearness_;
  Image<float> weights_, drawn_;
  Image<Tile> tiles_;
  Image<std::uint8_t> merged_;  // 1 where a map was
};

// The level of a view's depth whose pixels are at most as large as the bundle's rays.
const DepthLevel& LevelOf(const BundleGeometry& geometry, const SourceView& view,
                          const NearnessRange& range) {
  const RayBundle& bundle = geometry.bundle();
  const Eigen::Matrix4d map = view.view_from_world * geometry.world_from_bundle();
  const LocalMap local(map, 0.5 * bundle.width, 0.5 * bundle.height, range.middle);
  const float area = std::abs(local.xa * local.yb - local.xb * local.ya);
  return DepthLevelForSpacing(view, static_cast<double>(std::sqrt(area)));
}

}  // namespace

NearnessRange RangeInBundle(const BundleGeometry& geometry, const std::vector<SourceView>& views) {
  const RayBundle& bundle = geometry.bundle();
  std::vector<double> inside, all;
  for (const SourceView& view : views) {
    for (const Eigen::Vector4d& sample : view.samples) {
      const Eigen::Vector4d p = geometry.bundle_from_world() * sample;
      if (!(p.z() > 0)) continue;
      const double u = p.x() / p.z(), v = p.y() / p.z();
      const double n = p.w() / p.z();
      if (!std::isfinite(n)) continue;
      all.push_back(n);
      if (u >= 0 && v >= 0 && u <= bundle.width && v <= bundle.height) inside.push_back(n);
    }
  }
  std::vector<double>& values = inside.empty() ? all : inside;
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double q) {
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
  };
  return {quantile(0.1), quantile(0.5), quantile(0.9)};
}

Image<float> TargetDepth(const BundleGeometry& geometry, const std::vector<SourceView>& views,
                         const NearnessRange& range, const ViewRanking& ranking,
                         const TargetDepthOptions& options, int first_row, int end_row) {
  const RayBundle& bundle = geometry.bundle();
  // Bands begin where they always do: squares are rounded from a band's first row on.
  const int first_tile = std::max(first_row / kTile - kFillTiles, 0) / kBandTiles * kBandTiles;
  const int end_tile = std::min(Tiles(end_row) + kFillTiles, Tiles(bundle.height));
  const int first = first_tile * kTile, end = std::min(end_tile * kTile, bundle.height);
  const Wishes wishes =
      CollectWishes(geometry, views, range, ranking, options, first_tile, end_tile);
  std::vector<Landing> landings(views.size());
  ParallelForEach(0, static_cast<std::int64_t>(views.size()), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    if (wishes[k].empty()) return;
    landings[k] = LandingOf(geometry, views[k], LevelOf(geometry, views[k], range));
  });
  Image<float> nearness(bundle.width, end - first);
  const int bands = (end_tile - first_tile + kBandTiles - 1) / kBandTiles;
  ParallelForEach(0, bands, [&](std::int64_t b) {
    const int tile_row = first_tile + static_cast<int>(b) * kBandTiles;
    const int y = tile_row * kTile;
    const Rect rows{0, y - first, bundle.width, std::min(kBandTiles * kTile, end - y)};
    Band band(tile_row, nearness.span().Sub(rows));
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (wishes[k].empty()) continue;
      band.Merge(landings[k], wishes[k], 0, options.maps - 1, false);
    }
    for (int rank = options.maps; rank < options.maps + options.further; ++rank) {
      for (std::size_t k = 0; k < views.size(); ++k) {
        if (wishes[k].empty()) continue;
        band.Merge(landings[k], wishes[k], rank, rank, true);
      }
    }
  });
  FillFromFartherSide(static_cast<float>(range.middle), kFillTiles * kTile, nearness.span());
  if (first == first_row && end == end_row) return nearness;
  Image<float> wanted(bundle.width, end_row - first_row);
  std::copy_n(nearness.row(first_row - first), wanted.size(), wanted.data());
  return wanted;
}

double TargetDepthBytes(int width, int rows) {
  // Whole tiles with those around them: nearness, what fills its holes, and the wanted rows.
  const double all = rows + (2.0 * (kFillTiles + 1) + kBandTiles - 1) * kTile;
  const double of_band = 2.0 * kBandTiles * kTile;
  return sizeof(float) * static_cast<double>(width) * (3 * all + NumThreads() * of_band);
}

}  // namespace lamella
