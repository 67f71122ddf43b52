#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "distribute/accumulate_kernels.cc"
#include "distribute/accumulate_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The four floats of a Light, or as many of them as a vector has.
using LightTag = hn::CappedTag<float, 4>;
constexpr std::size_t kStep = hn::MaxLanes(LightTag());

#if HWY_TARGET == HWY_SCALAR

void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int first_layer,
             int layers, Light* out) {
  for (int l = 0; l < layers; ++l, out += count) {
    for (int i = 0; i < count; ++i) {
      const RaySample& sample = samples[i];
      const float light = sample.color.r + sample.color.g + sample.color.b;
      out[i] = Light();
      if (!(sample.coverage > 0 && std::isfinite(light))) continue;
      const float scale = weights.Weight(first_layer + l, sample.z) * sample.coverage;
      out[i] = {scale * sample.color.r, scale * sample.color.g, scale * sample.color.b,
                sample.coverage};
    }
  }
}

#else

// A sample is three pairs of floats, (r, g), (b, z), (confidence, coverage), and a Light two. Pairs
// are lanes here, so that no float has to be moved to another place.
using PairTag = hn::ScalableTag<std::uint64_t>;
using FloatTag = hn::Repartition<float, PairTag>;
using Floats = hn::VFromD<FloatTag>;
static_assert(sizeof(RaySample) == 24 && sizeof(Light) == 16);

// Share of the depths in the odd lanes that lies in front of the border, in the same lanes.
HWY_INLINE Floats InFront(Floats z, const LayerWeights::Border& border) {
  const FloatTag d;
  const auto one = hn::Set(d, 1.0F), at = hn::Set(d, border.at_mm);
  if (border.per_mm == 0) return hn::IfThenElseZero(hn::Ge(z, at), one);
  const auto t = hn::Add(hn::Mul(hn::Sub(z, at), hn::Set(d, border.per_mm)), hn::Set(d, 0.5F));
  // Nothing of NaN.
  return hn::IfThenElseZero(hn::Gt(t, hn::Zero(d)), hn::Min(t, one));
}

// As many samples as there are pairs in a vector, for kLayers layers, of which `borders` are behind
// and before each; the layers' lights are `stride` apart.
template <int kLayers>
HWY_INLINE void TakePairs(const RaySample* samples,
                          const std::array<const LayerWeights::Border*, kLayers + 1>& borders,
                          std::size_t stride, Light* out) {
  const PairTag pairs;
  const FloatTag d;
  hn::VFromD<PairTag> rg_pairs, bz_pairs, cc_pairs;
  hn::LoadInterleaved3(pairs, reinterpret_cast<const std::uint64_t*>(samples), rg_pairs, bz_pairs,
                       cc_pairs);
  const Floats rg = hn::BitCast(d, rg_pairs), bz = hn::BitCast(d, bz_pairs),
               cc = hn::BitCast(d, cc_pairs);
  const auto light = hn::Add(hn::Add(hn::DupEven(rg), hn::DupOdd(rg)), hn::DupEven(bz));
  const auto coverage = hn::DupOdd(cc);
  const auto known = hn::And(hn::IsFinite(light), hn::Gt(coverage, hn::Zero(d)));
  Floats behind = borders[0] != nullptr ? InFront(bz, *borders[0]) : hn::Set(d, 1.0F);
  for (int l = 0; l < kLayers; ++l, out += stride) {
    const Floats before = borders[l + 1] != nullptr ? InFront(bz, *borders[l + 1]) : hn::Zero(d);
    const auto scale = hn::Mul(hn::DupOdd(hn::Sub(behind, before)), coverage);
    const auto first = hn::IfThenElseZero(known, hn::Mul(rg, scale));
    const auto second = hn::IfThenElseZero(known, hn::OddEven(coverage, hn::Mul(bz, scale)));
    hn::StoreInterleaved2(hn::BitCast(pairs, first), hn::BitCast(pairs, second), pairs,
                          reinterpret_cast<std::uint64_t*>(out));
    behind = before;
  }
}

template <int kLayers>
void TakeRowOf(const RaySample* samples, int count, const LayerWeights& weights, int first_layer,
               Light* out) {
  std::array<const LayerWeights::Border*, kLayers + 1> borders;
  for (int l = 0; l < kLayers; ++l) borders[l] = weights.Behind(first_layer + l);
  borders[kLayers] = weights.Before(first_layer + kLayers - 1);
  constexpr std::size_t kMost = hn::MaxLanes(PairTag());
  const int step = static_cast<int>(hn::Lanes(PairTag()));
  int i = 0;
  for (; i + step <= count; i += step) {
    TakePairs<kLayers>(samples + i, borders, static_cast<std::size_t>(count), out + i);
  }
  if (i == count) return;
  std::array<RaySample, kMost> rest{};
  std::array<Light, kLayers * kMost> taken;
  std::copy(samples + i, samples + count, rest.begin());
  TakePairs<kLayers>(rest.data(), borders, kMost, taken.data());
  for (int l = 0; l < kLayers; ++l) {
    std::copy_n(taken.begin() + l * kMost, count - i, out + l * count + i);
  }
}

void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int first_layer,
             int layers, Light* out) {
  const auto take = layers == 2 ? TakeRowOf<2> : TakeRowOf<1>;
  take(samples, count, weights, first_layer, out);
}

#endif  // HWY_SCALAR

// kTaps 0: as many as `taps` says.
template <int kTaps>
void AddFilteredBy(const Light* row, std::span<const int> firsts, const float* weights, int taps,
                   Light* sums) {
  const LightTag d;
  const int count = kTaps > 0 ? kTaps : taps;
  for (const int first : firsts) {
    const float* sample = &row[first].r;
    for (std::size_t c = 0; c < 4; c += kStep) {
      auto sum = hn::Load(d, &sums->r + c);
      for (int t = 0; t < count; ++t) {
        sum = hn::Add(sum, hn::Mul(hn::Set(d, weights[t]), hn::Load(d, sample + 4 * t + c)));
      }
      hn::Store(sum, d, &sums->r + c);
    }
    weights += count;
    ++sums;
  }
}

void AddFiltered(const Light* row, std::span<const int> firsts, const float* weights, int taps,
                 Light* sums) {
  const auto add = taps == 1   ? AddFilteredBy<1>
                   : taps == 2 ? AddFilteredBy<2>
                   : taps == 3 ? AddFilteredBy<3>
                   : taps == 4 ? AddFilteredBy<4>
                   : taps == 5 ? AddFilteredBy<5>
                               : AddFilteredBy<0>;
  add(row, firsts, weights, taps, sums);
}

// Of the floats [first, end), as many at a time as `d` has lanes.
template <class D>
std::size_t AddRowsBy(D d, const Light* const* rows, const float* weights, int taps,
                      std::size_t first, std::size_t end, Light* sums) {
  std::size_t i = first;
  for (; i + hn::Lanes(d) <= end; i += hn::Lanes(d)) {
    auto sum = hn::LoadU(d, &sums->r + i);
    for (int t = 0; t < taps; ++t) {
      sum = hn::Add(sum, hn::Mul(hn::Set(d, weights[t]), hn::LoadU(d, &rows[t]->r + i)));
    }
    hn::StoreU(sum, d, &sums->r + i);
  }
  return i;
}

void AddRows(const Light* const* rows, const float* weights, int taps, int count, Light* sums) {
  const std::size_t floats = 4 * static_cast<std::size_t>(count);
  const std::size_t done =
      AddRowsBy(hn::ScalableTag<float>(), rows, weights, taps, 0, floats, sums);
  AddRowsBy(LightTag(), rows, weights, taps, done, floats, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {

HWY_EXPORT(TakeRow);
HWY_EXPORT(AddFiltered);
HWY_EXPORT(AddRows);

void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int first_layer,
             int layers, Light* out) {
  HWY_DYNAMIC_DISPATCH(TakeRow)(samples, count, weights, first_layer, layers, out);
}

void AddFiltered(const Light* row, std::span<const int> firsts, const float* weights, int taps,
                 Light* sums) {
  HWY_DYNAMIC_DISPATCH(AddFiltered)(row, firsts, weights, taps, sums);
}

void AddRows(const Light* const* rows, const float* weights, int taps, int count, Light* sums) {
  HWY_DYNAMIC_DISPATCH(AddRows)(rows, weights, taps, count, sums);
}

}  // namespace lamella
#endif  // HWY_ONCE
