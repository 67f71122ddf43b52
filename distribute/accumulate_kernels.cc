#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "distribute/accumulate_kernels.cc"
#include "distribute/accumulate_kernels.h"

#include <algorithm>
#include <array>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The four floats of a Light, or as many of them as a vector has.
using LightTag = hn::CappedTag<float, 4>;
constexpr std::size_t kStep = hn::MaxLanes(LightTag());

constexpr int kBlock = 64;

// weight[i] += sign * the share of sample i that lies in front of the border.
void AddInFront(const RaySample* samples, int count, const LayerWeights::Border& border, float sign,
                float* weight) {
  if (border.per_mm == 0) {
    for (int i = 0; i < count; ++i) weight[i] += samples[i].z >= border.at_mm ? sign : 0.0F;
    return;
  }
  const float at = border.at_mm, per_mm = border.per_mm;
  for (int i = 0; i < count; ++i) {
    const float t = (samples[i].z - at) * per_mm + 0.5F;
    weight[i] += sign * (t > 0 ? (t < 1 ? t : 1.0F) : 0.0F);
  }
}

// Of up to kBlock samples: what their colours are multiplied by, and their coverages; both are 0
// where nothing is known or the colour is not finite.
void WeighBlock(const RaySample* samples, int count, const LayerWeights& weights, int layer,
                float* scale, float* coverage) {
  const auto *behind = weights.Behind(layer), *before = weights.Before(layer);
  for (int i = 0; i < count; ++i) scale[i] = behind != nullptr ? 0.0F : 1.0F;
  if (behind != nullptr) AddInFront(samples, count, *behind, 1, scale);
  if (before != nullptr) AddInFront(samples, count, *before, -1, scale);
  for (int i = 0; i < count; ++i) {
    const float light = samples[i].color.r + samples[i].color.g + samples[i].color.b;
    const float known = light - light == 0 ? samples[i].coverage : 0.0F;
    coverage[i] = known > 0 ? known : 0.0F;
    scale[i] *= coverage[i];
  }
}

void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int layer,
             Light* out) {
  const LightTag d;
  std::array<float, kBlock> scale, coverage;
  for (int first = 0; first < count; first += kBlock) {
    const int n = std::min(kBlock, count - first);
    WeighBlock(samples + first, n, weights, layer, scale.data(), coverage.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      const float* color = &samples[first + static_cast<int>(i)].color.r;
      Light& light = out[first + static_cast<int>(i)];
      const auto known = hn::Gt(hn::Set(d, coverage[i]), hn::Zero(d));
      // The fourth is the depth, whose place the coverage takes.
      for (std::size_t c = 0; c < 4; c += kStep) {
        const auto taken = hn::Mul(hn::LoadU(d, color + c), hn::Set(d, scale[i]));
        hn::Store(hn::IfThenElseZero(known, taken), d, &light.r + c);
      }
      light.coverage = coverage[i];
    }
  }
}

void FilterRow(const Light* row, int first_x, const std::vector<Overlap>& overlaps,
               const float* weights, Light* out) {
  const LightTag d;
  for (const Overlap& overlap : overlaps) {
    const float* sample = &row[overlap.first_sample - first_x].r;
    const float* weight = weights + overlap.weights;
    for (std::size_t c = 0; c < 4; c += kStep) {
      auto sum = hn::Mul(hn::Set(d, weight[0]), hn::Load(d, sample + c));
      for (int i = 1; i < overlap.num_samples; ++i) {
        sum = hn::Add(sum, hn::Mul(hn::Set(d, weight[i]), hn::Load(d, sample + 4 * i + c)));
      }
      hn::Store(sum, d, &out->r + c);
    }
    ++out;
  }
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
HWY_EXPORT(FilterRow);
HWY_EXPORT(AddRows);

void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int layer,
             Light* out) {
  HWY_DYNAMIC_DISPATCH(TakeRow)(samples, count, weights, layer, out);
}

void FilterRow(const Light* row, int first_x, const std::vector<Overlap>& overlaps,
               const float* weights, Light* out) {
  HWY_DYNAMIC_DISPATCH(FilterRow)(row, first_x, overlaps, weights, out);
}

void AddRows(const Light* const* rows, const float* weights, int taps, int count, Light* sums) {
  HWY_DYNAMIC_DISPATCH(AddRows)(rows, weights, taps, count, sums);
}

}  // namespace lamella
#endif  // HWY_ONCE
