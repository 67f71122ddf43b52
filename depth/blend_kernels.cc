#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/blend_kernels.cc"
#include "depth/blend_kernels.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef LAMELLA_DEPTH_BLEND_KERNELS_SHARED
#define LAMELLA_DEPTH_BLEND_KERNELS_SHARED
namespace lamella {
namespace blend_kernels {

// Weight of direction: 1 / (kOwnView + offset^2), offset in neighbour spacings.
constexpr float kOwnView = 0.02F;
// Views that may not see the ray count as much of a view that does.
constexpr float kUnknownShare = 1e-2F, kHiddenShare = 1e-4F, kOutsideShare = 1e-6F;
// Less than this of what is already there is not worth a lookup.
constexpr float kNegligible = 1e-3F;
constexpr float kSeen = 0.5F;  // sum of visibilities from which on a ray counts as seen

}  // namespace blend_kernels
}  // namespace lamella
#endif  // LAMELLA_DEPTH_BLEND_KERNELS_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace blend_kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kRayPadding>;
using Ints = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Ints>;
using M = hn::Mask<Floats>;

inline F Constant(float value) { return hn::Set(Floats(), value); }

struct Placed {
  F x, y, w, m;
};

// LocalMap::operator() on lanes.
inline Placed Place(const LocalMap& map, F da, F db, F dc, F c) {
  const F m =
      Constant(map.m0) + Constant(map.ma) * da + Constant(map.mb) * db + Constant(map.mc) * dc;
  const F inverse = Constant(1.0F) / m;
  const F x =
      Constant(map.x_0) + Constant(map.xa) * da + Constant(map.xb) * db + Constant(map.xc) * dc;
  const F y =
      Constant(map.y_0) + Constant(map.ya) * da + Constant(map.yb) * db + Constant(map.yc) * dc;
  const F q =
      Constant(map.q_0) + Constant(map.qa) * da + Constant(map.qb) * db + Constant(map.qc) * c;
  return {Constant(map.x0) + x * inverse, Constant(map.y0) + y * inverse, q * inverse, m};
}

// Weight of direction: exact at the tile's corners, bilinear between them.
inline F DirectionWeight(const std::array<float, 4>& corners, F du, F dv) {
  const F half = Constant(0.5F), per_tile = Constant(1.0F / kTile);
  const F s = du * per_tile + half, t = dv * per_tile + half;
  const F upper = Constant(corners[0]) + s * Constant(corners[1] - corners[0]);
  const F lower = Constant(corners[2]) + s * Constant(corners[3] - corners[2]);
  return Constant(1.0F) / (Constant(kOwnView) + upper + t * (lower - upper));
}

// Values of neighbouring columns, at `at` and right of it.
struct Neighbours {
  F left, right;
};

#if HWY_MAX_BYTES >= 32
// Two neighbours are one number of twice the size: half of the lookups.
inline Neighbours GatherNeighbours(const float* values, I at) {
  const Floats d;
  const hn::Half<Ints> half;
  const hn::Repartition<std::int64_t, Floats> offsets;
  const hn::Repartition<std::uint64_t, Floats> pairs;
  const auto* from = reinterpret_cast<const std::uint64_t*>(values);
  const auto gather = [&](hn::Vec<hn::Half<Ints>> index) {
    const auto bytes = hn::ShiftLeft<2>(hn::PromoteTo(offsets, index));
    return hn::BitCast(d, hn::GatherOffset(pairs, from, bytes));
  };
  const F lower = gather(hn::LowerHalf(half, at)), upper = gather(hn::UpperHalf(half, at));
  return {hn::ConcatEven(d, upper, lower), hn::ConcatOdd(d, upper, lower)};
}
#else
inline Neighbours GatherNeighbours(const float* values, I at) {
  const Floats d;
  return {hn::GatherIndex(d, values, at), hn::GatherIndex(d, values + 1, at)};
}
#endif

struct Looked {
  F visible, confidence;
  M known;
};

// What the view's depth says of points at (x, y), inside of the picture, with inverse depth w.
inline Looked Look(const TileView& view, F x, F y, F w) {
  const Floats d;
  const Ints di;
  const DepthLevel& level = *view.depth;
  const F half = Constant(0.5F), zero = hn::Zero(d);
  const F px = x * Constant(static_cast<float>(level.per_color_x)) + half;
  const F py = y * Constant(static_cast<float>(level.per_color_y)) + half;
  // Clamped as integers too: what is not a number must not be an index.
  const I cx = hn::Max(hn::Min(hn::ConvertTo(di, px), hn::Set(di, level.width)), hn::Zero(di));
  const I cy = hn::Max(hn::Min(hn::ConvertTo(di, py), hn::Set(di, level.height)), hn::Zero(di));
  const F s = px - hn::ConvertTo(d, cx), t = py - hn::ConvertTo(d, cy);
  const int stride = level.inverse_depth.width();
  const I at = cy * hn::Set(di, stride) + cx;
  const float* inverse_depth = level.inverse_depth.data();
  const auto [a, b] = GatherNeighbours(inverse_depth, at);
  const auto [c, e] = GatherNeighbours(inverse_depth + stride, at);
  const I flags =
      hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(level.smooth.data()), at);
  const M smooth = hn::RebindMask(d, hn::And(flags, hn::Set(di, 1)) != hn::Zero(di));
  const F upper = a + s * (b - a), lower = c + s * (e - c);
  const F there =
      hn::IfThenElse(smooth, upper + t * (lower - upper), hn::Max(hn::Max(a, b), hn::Max(c, e)));
  const M known = there >= zero;
  const F softness = Constant(view.softness_absolute) + Constant(view.softness_relative) * w;
  const F q = (there - w) / softness;
  // exp(-q^2 / 2) to 0.05, and 0 from 2.83 on.
  const F base = hn::Max(Constant(1.0F) - q * q * Constant(0.125F), zero);
  const F square = base * base;
  const F visible = hn::IfThenElseZero(known, square * square);
  if (hn::AllFalse(d, visible > zero)) return {zero, zero, known};
  const I right = hn::And(hn::BitCast(di, hn::VecFromMask(d, s >= half)), hn::Set(di, 1));
  const I below = hn::And(hn::BitCast(di, hn::VecFromMask(d, t >= half)), hn::Set(di, stride));
  const F confidence = hn::GatherIndex(d, level.confidence.data(), at + right + below);
  return {visible, confidence, known};
}

inline std::uint64_t Bits(M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Floats(), mask, bytes);
  std::uint64_t bits = 0;
  for (int i = 0; i < 8; ++i) bits |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  return bits;
}

// Lanes of a mask behind those of the rays before. (CompressStore loads a table for every call.)
inline void Append(int first, F x, F y, F weight, M mask, ActiveRays& active) {
  const Floats d;
  const Ints di;
  const auto to = static_cast<std::size_t>(active.count);
  hn::StoreU(hn::Iota(di, first), di, &active.ray[to]);
  hn::StoreU(x, d, &active.x[to]);
  hn::StoreU(y, d, &active.y[to]);
  hn::StoreU(weight, d, &active.weight[to]);
  if (hn::AllTrue(d, mask)) {
    active.count += static_cast<int>(hn::Lanes(d));
    return;
  }
  std::size_t end = to;
  for (std::uint64_t bits = Bits(mask); bits != 0; bits &= bits - 1, ++end) {
    const std::size_t from = to + static_cast<std::size_t>(std::countr_zero(bits));
    active.ray[end] = active.ray[from];
    active.x[end] = active.x[from];
    active.y[end] = active.y[from];
    active.weight[end] = active.weight[from];
  }
  active.count = static_cast<int>(end);
}

void See(const TileView& view, bool unseen_only, TileRays& rays, ActiveRays& active) {
  const Floats d;
  const F zero = hn::Zero(d), one = Constant(1.0F);
  const F width = Constant(view.width), height = Constant(view.height);
  const F at_nearness = Constant(view.at_nearness);
  const int lanes = static_cast<int>(hn::Lanes(d));
  active.count = 0;
  for (int i = 0; i < rays.count; i += lanes) {
    const auto k = static_cast<std::size_t>(i);
    const F seen = hn::LoadU(d, &rays.seen[k]);
    M wanted = hn::FirstN(d, static_cast<std::size_t>(rays.count - i));
    if (unseen_only) {
      wanted = hn::And(wanted, seen <= Constant(kSeen));
      if (hn::AllFalse(d, wanted)) continue;
    }
    const F du = hn::LoadU(d, &rays.du[k]), dv = hn::LoadU(d, &rays.dv[k]);
    const F n = hn::LoadU(d, &rays.nearness[k]);
    const Placed p = Place(view.view_from_tile, du, dv, n - at_nearness, n);
    wanted = hn::And(wanted, p.m > zero);
    const F inside = hn::Min(hn::Min(p.x, width - p.x), hn::Min(p.y, height - p.y));
    const F x = hn::Max(hn::Min(p.x, width), zero), y = hn::Max(hn::Min(p.y, height), zero);
    const M is_inside = hn::And(wanted, inside >= zero);
    const Looked look =
        hn::AllFalse(d, is_inside) ? Looked{zero, zero, is_inside} : Look(view, x, y, p.w);
    const F visible = hn::IfThenElseZero(is_inside, look.visible);
    const F fade = hn::Min((inside + Constant(0.5F)) * Constant(view.per_fade), one);
    const F little = hn::IfThenElse(look.known, Constant(kHiddenShare), Constant(kUnknownShare));
    const F share = hn::IfThenElse(is_inside, fade * (visible + little),
                                   Constant(kOutsideShare) / (one + inside * inside));
    const F direction = DirectionWeight(view.penalty, du, dv);
    const F weight = direction * share, before = hn::LoadU(d, &rays.weight[k]);
    const F confidence =
        hn::IfThenElseZero(is_inside, direction * fade * visible * look.confidence);
    hn::StoreU(seen + visible, d, &rays.seen[k]);
    hn::StoreU(hn::Max(hn::LoadU(d, &rays.most_seen[k]), visible), d, &rays.most_seen[k]);
    hn::StoreU(hn::LoadU(d, &rays.confidence[k]) + confidence, d, &rays.confidence[k]);
    const M adds = hn::And(wanted, weight > Constant(kNegligible) * before);
    hn::StoreU(before + hn::IfThenElseZero(adds, weight), d, &rays.weight[k]);
    if (hn::AllFalse(d, adds)) continue;
    Append(i, x, y, weight, adds, active);
  }
}

// Where a filter of four taps begins, and their weights, for as many positions as there are lanes.
struct Taps {
  PerRay<std::int32_t> first;
  PerRay<float> weights[4];
};

inline void FilterTaps(const PerRay<float>& position, int count, float scale, int size, bool cubic,
                       Taps& taps) {
  const Floats d;
  const Ints di;
  const F one = Constant(1.0F), half = Constant(0.5F);
  // Padded coordinates: pixel 0 is at kPad.
  const F shift = Constant(static_cast<float>(ColorLevel::kPad) - 0.5F);
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const auto k = static_cast<std::size_t>(i);
    const F at = hn::LoadU(d, &position[k]) * Constant(scale) + shift;
    const I base = hn::Min(hn::ConvertTo(di, at), hn::Set(di, size + 1));
    const F f = at - hn::ConvertTo(d, base);
    hn::StoreU(base - hn::Set(di, 1), di, &taps.first[k]);
    if (!cubic) {
      hn::StoreU(hn::Zero(d), d, &taps.weights[0][k]);
      hn::StoreU(one - f, d, &taps.weights[1][k]);
      hn::StoreU(f, d, &taps.weights[2][k]);
      hn::StoreU(hn::Zero(d), d, &taps.weights[3][k]);
      continue;
    }
    const F f2 = f * f, f3 = f2 * f;
    hn::StoreU(f2 - half * (f3 + f), d, &taps.weights[0][k]);
    hn::StoreU(Constant(1.5F) * f3 - Constant(2.5F) * f2 + one, d, &taps.weights[1][k]);
    hn::StoreU(Constant(2.0F) * f2 - Constant(1.5F) * f3 + half * f, d, &taps.weights[2][k]);
    hn::StoreU(half * (f3 - f2), d, &taps.weights[3][k]);
  }
}

// Four pixels of a row with their weights: (w0 p0 + w2 p2) + (w1 p1 + w3 p3), in this order for all
// vector sizes.
using Channels = hn::CappedTag<float, 4>;
using C = hn::Vec<Channels>;
constexpr int kChannelLanes = static_cast<int>(hn::MaxLanes(Channels()));
constexpr int kChannelSteps = 4 / kChannelLanes;  // 4 on the scalar target

#if HWY_MAX_BYTES >= 32
using TwoPixels = hn::FixedTag<float, 8>;
struct RowWeights {
  hn::Vec<TwoPixels> w01, w23;
  RowWeights(float w0, float w1, float w2, float w3)
      : w01(hn::Combine(TwoPixels(), hn::Set(Channels(), w1), hn::Set(Channels(), w0))),
        w23(hn::Combine(TwoPixels(), hn::Set(Channels(), w3), hn::Set(Channels(), w2))) {}
};
struct PixelSum {
  hn::Vec<TwoPixels> both;

  PixelSum() : both(hn::Zero(TwoPixels())) {}
  void AddRow(float weight, const hwy::float16_t* pixels, const RowWeights& w) {
    const TwoPixels d;
    const hn::Rebind<hwy::float16_t, TwoPixels> dh;
    const auto p01 = hn::PromoteTo(d, hn::LoadU(dh, pixels));
    const auto p23 = hn::PromoteTo(d, hn::LoadU(dh, pixels + 8));
    both = both + hn::Set(d, weight) * (w.w01 * p01 + w.w23 * p23);
  }
  C Total(int) const { return hn::LowerHalf(Channels(), both) + hn::UpperHalf(Channels(), both); }
};
#else
struct RowWeights {
  float w0, w1, w2, w3;
};
struct PixelSum {
  C even[kChannelSteps], odd[kChannelSteps];

  PixelSum() {
    for (int c = 0; c < kChannelSteps; ++c) even[c] = odd[c] = hn::Zero(Channels());
  }
  void AddRow(float weight, const hwy::float16_t* pixels, const RowWeights& w) {
    const Channels d;
    const hn::Rebind<hwy::float16_t, Channels> dh;
    for (int c = 0; c < kChannelSteps; ++c) {
      const auto term = [&](int pixel, float share) {
        const auto* from = pixels + 4 * pixel + c * kChannelLanes;
        return hn::Set(d, share) * hn::PromoteTo(d, hn::LoadU(dh, from));
      };
      even[c] = even[c] + hn::Set(d, weight) * (term(0, w.w0) + term(2, w.w2));
      odd[c] = odd[c] + hn::Set(d, weight) * (term(1, w.w1) + term(3, w.w3));
    }
  }
  C Total(int c) const { return even[c] + odd[c]; }
};
#endif

void Add(const ColorLevel& level, bool cubic, const ActiveRays& active, TileRays& rays) {
  const Channels d;
  Taps columns, rows;
  FilterTaps(active.x, active.count, level.scale_x, level.width, cubic, columns);
  FilterTaps(active.y, active.count, level.scale_y, level.height, cubic, rows);
  const int first_row = cubic ? 0 : 1, last_row = cubic ? 3 : 2;
  for (std::size_t i = 0; i < static_cast<std::size_t>(active.count); ++i) {
    const RowWeights w{columns.weights[0][i], columns.weights[1][i], columns.weights[2][i],
                       columns.weights[3][i]};
    const ColorLevel::Pixel* pixels = level.pixels.row(rows.first[i]) + columns.first[i];
    PixelSum sum;
    for (int j = first_row; j <= last_row; ++j) {
      const ColorLevel::Pixel* row = pixels + j * level.pixels.width();
      sum.AddRow(rows.weights[j][i], reinterpret_cast<const hwy::float16_t*>(row), w);
    }
    float* to = rays.color[static_cast<std::size_t>(active.ray[i])].channels;
    for (int c = 0; c < kChannelSteps; ++c, to += kChannelLanes) {
      const C color = hn::Max(sum.Total(c), hn::Zero(d));
      hn::StoreU(hn::LoadU(d, to) + hn::Set(d, active.weight[i]) * color, d, to);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace blend_kernels
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace blend_kernels {
HWY_EXPORT(See);
HWY_EXPORT(Add);
}  // namespace blend_kernels

void SeeTile(const TileView& view, bool unseen_only, TileRays& rays, ActiveRays& active) {
  using namespace blend_kernels;  // NOLINT
  HWY_DYNAMIC_DISPATCH(See)(view, unseen_only, rays, active);
}

void AddColors(const ColorLevel& level, bool cubic, const ActiveRays& active, TileRays& rays) {
  using namespace blend_kernels;  // NOLINT
  HWY_DYNAMIC_DISPATCH(Add)(level, cubic, active, rays);
}

}  // namespace lamella
#endif  // HWY_ONCE
