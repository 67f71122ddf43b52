// A pixel's four values are a vector of doubles, or two, without fused operations: every target
// gives the same bytes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "distribute/box_blur.cc"
#include "distribute/box_blur.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Values = hn::CappedTag<double, 4>;
constexpr std::size_t kValues = 4;  // of a pixel

HWY_INLINE hn::Vec<Values> LoadValues(const float* values) {
  return hn::PromoteTo(Values(), hn::LoadU(hn::Rebind<float, Values>(), values));
}

// The sum of weights of full size is followed; the pixels beside it are `before` and `behind`.
HWY_INLINE void StoreFiltered(const BoxFilter& box, hn::Vec<Values> sum, hn::Vec<Values> before,
                              hn::Vec<Values> behind, float* out) {
  const auto edge = hn::Set(Values(), box.edge), scale = hn::Set(Values(), box.scale);
  const hn::Rebind<float, Values> floats;
  hn::StoreU(hn::DemoteTo(floats, scale * (sum + edge * (before + behind))), floats, out);
}

void BlurRow(const BoxFilter& box, const Light* in, int count, Light* out) {
  for (std::size_t value = 0; value < kValues; value += hn::Lanes(Values())) {
    const auto load = [&](int i) { return LoadValues(&in[i].r + value); };
    auto sum = hn::Zero(Values());
    for (int i = -box.core; i <= box.core; ++i) sum = sum + load(i);
    auto before = load(-box.core - 1);
    for (int i = 0; i < count; ++i) {
      const auto behind = load(i + box.core + 1);
      StoreFiltered(box, sum, before, behind, &out[i].r + value);
      before = load(i - box.core);
      sum = sum + (behind - before);
    }
  }
}

// `sums` of a row's pixels move on by one row; `last` is the first row that they had.
void BlurColumnsOfRow(const BoxFilter& box, const Light* before, const Light* last,
                      const Light* behind, int count, double* HWY_RESTRICT sums, Light* out) {
  for (std::size_t i = 0; i < kValues * static_cast<std::size_t>(count); i += hn::Lanes(Values())) {
    const auto sum = hn::LoadU(Values(), sums + i), next = LoadValues(&behind->r + i);
    StoreFiltered(box, sum, LoadValues(&before->r + i), next, &out->r + i);
    hn::StoreU(sum + (next - LoadValues(&last->r + i)), Values(), sums + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {

HWY_EXPORT(BlurRow);
HWY_EXPORT(BlurColumnsOfRow);

BoxFilter BoxOfWidth(double width_px) {
  const double variance = width_px * width_px / 12;
  BoxFilter box;
  box.core = static_cast<int>((std::sqrt(width_px * width_px + 1) - 1) / 2);
  const double core = box.core, full = 2 * core + 1;
  // (2 (1 + 4 + ... + core^2) + 2 edge (core + 1)^2) / (full + 2 edge) = variance.
  box.edge = full * (variance - core * (core + 1) / 3) / (2 * ((core + 1) * (core + 1) - variance));
  box.edge = box.edge > 0 ? box.edge : 0;  // rounding
  box.scale = 1 / (full + 2 * box.edge);
  return box;
}

void BlurRow(const BoxFilter& box, const Light* in, int count, Light* out) {
  HWY_DYNAMIC_DISPATCH(BlurRow)(box, in, count, out);
}

void BlurColumns(const BoxFilter& box, ImageSpan<const Light> in, ImageSpan<Light> out) {
  std::vector<double> sums;
  for (int x = 0; x < out.width; ++x) {
    double r = 0, g = 0, b = 0, coverage = 0;
    for (int j = 1; j <= 2 * box.core + 1; ++j) {
      r += static_cast<double>(in(x, j).r);
      g += static_cast<double>(in(x, j).g);
      b += static_cast<double>(in(x, j).b);
      coverage += static_cast<double>(in(x, j).coverage);
    }
    sums.insert(sums.end(), {r, g, b, coverage});
  }
  for (int y = 0; y < out.height; ++y) {
    HWY_DYNAMIC_DISPATCH(BlurColumnsOfRow)
    (box, in.row(y), in.row(y + 1), in.row(y + 2 * box.core + 2), out.width, sums.data(),
     out.row(y));
  }
}

}  // namespace lamella
#endif  // HWY_ONCE
