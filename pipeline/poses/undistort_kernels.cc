#include "pipeline/poses/undistort_kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pipeline/poses/undistort_kernels.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using Floats = hn::Rebind<float, Doubles>;
using Ints = hn::Rebind<std::int32_t, Doubles>;
using Vector = hn::Vec<Doubles>;
using FloatVector = hn::Vec<Floats>;

void Interpolate(const std::array<Eigen::Vector2d, 4>& knots, int step, int begin, SourceRow& row) {
  const Doubles d;
  const auto constant = [&](double value) { return hn::Set(d, value); };
  const Vector one = constant(1), two = constant(2);
  for (int i = 0; i < step; i += static_cast<int>(hn::Lanes(d))) {
    const Vector t = hn::Iota(d, static_cast<double>(i)) / constant(step);
    const Vector outer = t * (t - one), inner = (t + one) * (t - two);
    const auto cubic = [&](int k) {
      const auto knot = [&](std::size_t j) { return constant(knots[j][k]); };
      return outer * ((one + t) * knot(3) - (t - two) * knot(0)) / constant(6) +
             inner * ((t - one) * knot(1) - t * knot(2)) / two;
    };
    const auto at = static_cast<std::size_t>(begin) + static_cast<std::size_t>(i);
    hn::StoreU(cubic(0), d, row.x.data() + at);
    hn::StoreU(cubic(1), d, row.y.data() + at);
  }
}

// Of the samples -1, 0, 1, 2 at `t` in [0, 1) after sample 0: Catmull-Rom in closed form.
void StoreWeights(FloatVector t, std::size_t at, std::array<std::vector<float>, 4>& weights) {
  const Floats d;
  const auto constant = [&](float value) { return hn::Set(d, value); };
  const FloatVector t2 = t * t, t3 = t2 * t;
  const auto store = [&](std::size_t k, FloatVector value) {
    hn::StoreU(value, d, weights[k].data() + at);
  };
  store(0, constant(-0.5F) * t3 + t2 - constant(0.5F) * t);
  store(1, constant(1.5F) * t3 - constant(2.5F) * t2 + constant(1));
  store(2, constant(-1.5F) * t3 + constant(2) * t2 + constant(0.5F) * t);
  store(3, constant(0.5F) * t3 - constant(0.5F) * t2);
}

void FindSamples(const Image<Rgb>& image, SourceRow& row) {
  const Doubles d;
  const Floats df;
  const Ints di;
  const Vector half = hn::Set(d, 0.5), one = hn::Set(d, 1.0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.width); i += hn::Lanes(d)) {
    const Vector x = hn::LoadU(d, row.x.data() + i) - half;
    const Vector y = hn::LoadU(d, row.y.data() + i) - half;
    const auto inside = hn::And(hn::And(x >= one, x < hn::Set(d, image.width() - 2.0)),
                                hn::And(y >= one, y < hn::Set(d, image.height() - 2.0)));
    // What is outside may not be a number: it is replaced before it becomes an index.
    const auto x0 = hn::DemoteTo(di, hn::IfThenElseZero(inside, x));
    const auto y0 = hn::DemoteTo(di, hn::IfThenElseZero(inside, y));
    StoreWeights(hn::DemoteTo(df, x - hn::PromoteTo(d, x0)), i, row.across);
    StoreWeights(hn::DemoteTo(df, y - hn::PromoteTo(d, y0)), i, row.down);
    const auto ones = hn::Set(di, 1);
    const auto first = (y0 - ones) * hn::Set(di, image.width()) + (x0 - ones);
    hn::StoreU(hn::IfThenElse(x0 > hn::Zero(di), first, hn::Set(di, -1)), di, row.first.data() + i);
  }
}

// A pixel's channels and one more.
using Channels = hn::CappedTag<float, 4>;
constexpr int kChannels = 4;

// The weighted sum of 4 x 4 pixels from `p` on; reads one channel more than they have, and writes
// one more.
void Sum(const float* HWY_RESTRICT p, std::ptrdiff_t stride, const SourceRow& row, std::size_t at,
         float* HWY_RESTRICT out) {
  const Channels d;
  const auto weight = [&](float value) { return hn::Set(d, value); };
  const auto w0 = weight(row.across[0][at]), w1 = weight(row.across[1][at]),
             w2 = weight(row.across[2][at]), w3 = weight(row.across[3][at]);
  for (int c = 0; c < kChannels; c += static_cast<int>(hn::Lanes(d))) {
    auto sum = hn::Zero(d);
    const float* q = p + c;
    for (std::size_t j = 0; j < 4; ++j, q += stride) {
      const auto line = w0 * hn::LoadU(d, q) + w1 * hn::LoadU(d, q + 3) + w2 * hn::LoadU(d, q + 6) +
                        w3 * hn::LoadU(d, q + 9);
      sum = sum + weight(row.down[j][at]) * line;
    }
    hn::StoreU(sum, d, out + c);
  }
}

void SampleRow(const Image<Rgb>& image, SourceRow& row, Rgb* out) {
  FindSamples(image, row);
  const auto floats = [](const Rgb* pixels) { return reinterpret_cast<const float*>(pixels); };
  auto* colors = reinterpret_cast<float*>(row.colors.data());
  const auto width = static_cast<std::size_t>(row.width);
  // From there on, the last of the samples is the image's last pixel.
  const std::int32_t last = static_cast<std::int32_t>(image.size()) - 3 * image.width() - 4;
  for (std::size_t i = 0; i < width; ++i) {
    const std::int32_t first = row.first[i];
    if (first < 0) continue;
    const Rgb* samples = image.data() + first;
    if (first < last) {
      Sum(floats(samples), 3 * static_cast<std::ptrdiff_t>(image.width()), row, i, colors + 3 * i);
      continue;
    }
    std::array<Rgb, 17> copy;
    for (int j = 0; j < 4; ++j)
      std::copy_n(samples + static_cast<std::ptrdiff_t>(j) * image.width(), 4, &copy[4U * j]);
    Sum(floats(copy.data()), 3 * 4, row, i, colors + 3 * i);
  }
  std::copy_n(row.colors.begin(), width, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
HWY_EXPORT(Interpolate);
HWY_EXPORT(SampleRow);

void InterpolateSources(const std::array<Eigen::Vector2d, 4>& knots, int step, int begin,
                        SourceRow& row) {
  HWY_DYNAMIC_DISPATCH(Interpolate)(knots, step, begin, row);
}

void SampleSharpRow(const Image<Rgb>& image, SourceRow& row, Rgb* out) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(image, row, out);
}

}  // namespace lamella
#endif  // HWY_ONCE
