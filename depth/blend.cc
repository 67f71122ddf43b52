#include "depth/blend.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr std::size_t kRays = static_cast<std::size_t>(kTile) * kTile;
// Weight of direction: 1 / (kOwnView + offset^2), offset in neighbour spacings.
constexpr double kOwnView = 0.02;
// Views that may not see the ray count as much of a view that does.
constexpr float kUnknownShare = 1e-2F, kHiddenShare = 1e-4F, kOutsideShare = 1e-6F;
// A view fades in over this share of its smaller side.
constexpr float kFade = 0.02F;
// Less than this of what is already there is not worth a lookup.
constexpr float kNegligible = 1e-3F;

struct Tile {
  std::array<float, kRays> x, y, w, m;  // where the rays are in a view
  std::array<float, kRays> weights, seen, most_seen, confidence, direction;
  std::array<ColorLevel::Pixel, kRays> sums;
};

// The weight of direction varies smoothly: exact at the tile's corners, bilinear between them.
class DirectionWeight {
 public:
  DirectionWeight(const BundleGeometry& geometry, const SourceView& view, const Sight& sight,
                  double neighbour, const Rect& tile) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double u = tile.x + (i % 2) * kTile, v = tile.y + (i / 2) * kTile;
      const double offset =
          std::sqrt(geometry.DistanceSquared(u, v, view.centre)) / neighbour + sight.resolution;
      corners_[i] = static_cast<float>(std::min(offset * offset, 1e12));
    }
  }
  // s, t in [0, 1] across the tile.
  float operator()(float s, float t) const {
    const float upper = corners_[0] + s * (corners_[1] - corners_[0]);
    const float lower = corners_[2] + s * (corners_[3] - corners_[2]);
    return 1.0F / (static_cast<float>(kOwnView) + upper + t * (lower - upper));
  }

 private:
  std::array<float, 4> corners_;
};

// What a view's depth says of a point at (x, y) in it with inverse depth w.
struct Visibility {
  float visible = 0;  // [0, 1]
  float confidence = 0;
  bool known = false;
};

Visibility Look(const DepthLevel& level, const SourceView& view, float x, float y, float w) {
  const float px = x * static_cast<float>(level.per_color_x) + 0.5F;
  const float py = y * static_cast<float>(level.per_color_y) + 0.5F;
  const int cx = std::min(static_cast<int>(px), level.width);
  const int cy = std::min(static_cast<int>(py), level.height);
  const DepthPixel* upper = &level.pixels(cx, cy);
  const DepthPixel* lower = &level.pixels(cx, cy + 1);
  const float s = px - static_cast<float>(cx), t = py - static_cast<float>(cy);
  float there;
  if (level.smooth(cx, cy) != 0) {
    const float a = upper[0].inverse_depth + s * (upper[1].inverse_depth - upper[0].inverse_depth);
    const float b = lower[0].inverse_depth + s * (lower[1].inverse_depth - lower[0].inverse_depth);
    there = a + t * (b - a);
  } else {
    // Beside an edge the nearest of the four decides: what lies behind it may be hidden or mixed.
    there = std::max(std::max(upper[0].inverse_depth, upper[1].inverse_depth),
                     std::max(lower[0].inverse_depth, lower[1].inverse_depth));
    if (there < 0) return {};
  }
  const float softness =
      static_cast<float>(view.softness_absolute) + static_cast<float>(view.softness_relative) * w;
  const float q = (there - w) / softness;
  // exp(-q^2 / 2) to 0.05, and 0 from 2.83 on.
  const float base = std::max(0.0F, 1.0F - q * q * 0.125F);
  const DepthPixel& nearest = (t < 0.5F ? upper : lower)[s < 0.5F ? 0 : 1];
  return {base * base * base * base, nearest.confidence, true};
}

// Taps and weights of a 1-D filter around position p (level pixels; padded index 0 is at
// -kPad + 0.5).
struct Taps {
  int first;
  float w[4];
};

Taps CatmullRom(float p) {
  const float at = p - 0.5F + static_cast<float>(ColorLevel::kPad);
  const int base = static_cast<int>(at);
  const float f = at - static_cast<float>(base), f2 = f * f, f3 = f2 * f;
  return {base - 1,
          {-0.5F * f3 + f2 - 0.5F * f, 1.5F * f3 - 2.5F * f2 + 1.0F,
           -1.5F * f3 + 2.0F * f2 + 0.5F * f, 0.5F * f3 - 0.5F * f2}};
}

Taps Linear(float p) {
  const float at = p - 0.5F + static_cast<float>(ColorLevel::kPad);
  const int base = static_cast<int>(at);
  const float f = at - static_cast<float>(base);
  return {base - 1, {0, 1 - f, f, 0}};
}

// Adds weight * colour; the filter's undershoot below black is cut.
void AddColor(const ColorLevel& level, bool cubic, float x, float y, float weight,
              ColorLevel::Pixel& sum) {
  const Taps column = cubic ? CatmullRom(x * level.scale_x) : Linear(x * level.scale_x);
  const Taps row = cubic ? CatmullRom(y * level.scale_y) : Linear(y * level.scale_y);
  float color[4] = {0, 0, 0, 0};
  for (int j = 0; j < 4; ++j) {
    const ColorLevel::Pixel* from = level.pixels.row(row.first + j) + column.first;
    float line[4] = {0, 0, 0, 0};
    for (int i = 0; i < 4; ++i) {
      for (int c = 0; c < 4; ++c) line[c] += column.w[i] * from[i].channels[c];
    }
    for (int c = 0; c < 4; ++c) color[c] += row.w[j] * line[c];
  }
  for (int c = 0; c < 4; ++c) sum.channels[c] += weight * std::max(0.0F, color[c]);
}

class TileBlender {
 public:
  TileBlender(const BundleGeometry& geometry, double neighbour, const BlendOptions& options,
              float tile_nearness, const Rect& rays, ImageSpan<const float> nearness)
      : geometry_(geometry),
        neighbour_(neighbour),
        options_(options),
        tile_nearness_(tile_nearness),
        rays_(rays),
        nearness_(nearness),
        tile_{rays.x / kTile * kTile, rays.y / kTile * kTile, kTile, kTile},
        count_(static_cast<std::size_t>(rays.width) * static_cast<std::size_t>(rays.height)) {
    std::fill_n(t_.weights.begin(), count_, 0.0F);
    std::fill_n(t_.seen.begin(), count_, 0.0F);
    std::fill_n(t_.most_seen.begin(), count_, 0.0F);
    std::fill_n(t_.confidence.begin(), count_, 0.0F);
    std::fill_n(t_.sums.begin(), count_, ColorLevel::Pixel());
  }

  // Adds a view; to the rays only that `unseen_only` leaves.
  void Add(const SourceView& view, const Sight& sight, bool unseen_only) {
    Map(view, sight);
    const double spacing = sight.spacing * geometry_.bundle().footprint;
    const DepthLevel& depth = DepthLevelForSpacing(view, spacing);
    const ColorLevel& color = ColorLevelForSpacing(view, spacing);
    const auto width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    const float per_fade = 1.0F / std::max(1.0F, kFade * std::min(width, height));
    for (std::size_t i = 0; i < count_; ++i) {
      if (unseen_only && t_.seen[i] > 0.5F) continue;
      if (!(t_.m[i] > 0)) continue;
      const float inside =
          std::min(std::min(t_.x[i], width - t_.x[i]), std::min(t_.y[i], height - t_.y[i]));
      const float x = std::min(std::max(t_.x[i], 0.0F), width);
      const float y = std::min(std::max(t_.y[i], 0.0F), height);
      float share;
      if (inside >= 0) {
        const Visibility v = Look(depth, view, x, y, t_.w[i]);
        const float fade = std::min(1.0F, (inside + 0.5F) * per_fade);
        share = fade * (v.visible + (v.known ? kHiddenShare : kUnknownShare));
        t_.seen[i] += v.visible;
        t_.most_seen[i] = std::max(t_.most_seen[i], v.visible);
        t_.confidence[i] += t_.direction[i] * fade * v.visible * v.confidence;
      } else {
        share = kOutsideShare / (1.0F + inside * inside);
      }
      const float weight = t_.direction[i] * share;
      if (!(weight > kNegligible * t_.weights[i])) continue;
      t_.weights[i] += weight;
      AddColor(color, options_.cubic, x, y, weight, t_.sums[i]);
    }
  }

  void Finish(const DistanceFromNearness& distance, ImageSpan<RaySample> samples) const {
    std::size_t i = 0;
    for (int y = 0; y < rays_.height; ++y) {
      for (int x = 0; x < rays_.width; ++x, ++i) {
        RaySample& sample = samples(x, y);
        sample = RaySample();
        sample.z = distance(nearness_(x, y));
        if (!(t_.weights[i] > 0)) continue;
        const float scale = 1.0F / t_.weights[i];
        const float* sum = t_.sums[i].channels;
        sample.color = {scale * sum[0], scale * sum[1], scale * sum[2]};
        sample.coverage = std::min(1.0F, 2.0F * t_.most_seen[i]);
        sample.confidence = std::min(1.0F, scale * t_.confidence[i]);
      }
    }
  }

 private:
  void Map(const SourceView& view, const Sight& sight) {
    const double at_u = tile_.x + 0.5 * kTile, at_v = tile_.y + 0.5 * kTile;
    const float at_n = tile_nearness_;
    const LocalMap map(view.view_from_world * geometry_.world_from_bundle(), at_u, at_v,
                       static_cast<double>(at_n));
    const DirectionWeight direction(geometry_, view, sight, neighbour_, tile_);
    std::size_t i = 0;
    for (int y = 0; y < rays_.height; ++y) {
      const float dv = static_cast<float>(rays_.y + y + 0.5 - at_v);
      const float t = dv / kTile + 0.5F;
      const float* row = nearness_.row(y);
      for (int x = 0; x < rays_.width; ++x, ++i) {
        const float du = static_cast<float>(rays_.x - tile_.x + x) + 0.5F - 0.5F * kTile;
        const LocalMap::Out out = map(du, dv, row[x] - at_n, row[x]);
        t_.x[i] = out.x;
        t_.y[i] = out.y;
        t_.w[i] = out.q;
        t_.m[i] = out.m;
        t_.direction[i] = direction(du / kTile + 0.5F, t);
      }
    }
  }

  const BundleGeometry& geometry_;
  double neighbour_;
  const BlendOptions& options_;
  float tile_nearness_;
  Rect rays_;
  ImageSpan<const float> nearness_;
  Rect tile_;
  std::size_t count_;
  Tile t_;
};

}  // namespace

void BlendTile(const BundleGeometry& geometry, const std::vector<SourceView>& views,
               const TileSights& tile, double neighbour, const BlendOptions& options,
               const Rect& rays, ImageSpan<const float> nearness, ImageSpan<RaySample> samples) {
  TileBlender blender(geometry, neighbour, options, tile.nearness, rays, nearness);
  for (std::size_t k = 0; k < tile.sights.size(); ++k) {
    const Sight& sight = tile.sights[k];
    blender.Add(views[static_cast<std::size_t>(sight.view)], sight,
                k >= static_cast<std::size_t>(options.views));
  }
  blender.Finish(DistanceFromNearness(geometry.bundle(), geometry.zero()), samples);
}

}  // namespace lamella
