// Vectors of doubles without fused operations, each lane a pixel: every target gives the same
// bytes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "distribute/similarity_kernels.cc"
#include "distribute/similarity_kernels.h"

#include <cmath>
#include <cstddef>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::ScalableTag<double>;

constexpr int kRadius = SimilarityWindow::kRadius, kNumMeans = RowMoments::kNumMeans;
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;

// Calls body(tag, x) for whole vectors from 0 on, and pixel by pixel for what is left.
template <class Body>
HWY_INLINE void ForEachPixel(int width, const Body& body) {
  const int lanes = static_cast<int>(hn::Lanes(Doubles()));
  int x = 0;
  for (; x + lanes <= width; x += lanes) body(Doubles(), x);
  for (; x < width; ++x) body(hn::CappedTag<double, 1>(), x);
}

void HorizontalMoments(const SimilarityWindow& window, const double* HWY_RESTRICT a,
                       const double* HWY_RESTRICT b, int width, RowMoments& moments) {
  ForEachPixel(width, [&](auto d, int x) {
    hn::Vec<decltype(d)> sums[kNumMeans];
    for (int i = 0; i <= kRadius; ++i) {
      const auto weight = hn::Set(d, window.weights[static_cast<std::size_t>(i)]);
      const auto add = [&](std::size_t k, hn::Vec<decltype(d)> value) {
        sums[k] = i == 0 ? weight * value : sums[k] + weight * value;
      };
      const auto a0 = hn::LoadU(d, a + x + kRadius - i), b0 = hn::LoadU(d, b + x + kRadius - i);
      if (i == 0) {
        add(0, a0);
        add(1, b0);
        add(2, a0 * a0);
        add(3, b0 * b0);
        add(4, a0 * b0);
      } else {
        const auto a1 = hn::LoadU(d, a + x + kRadius + i), b1 = hn::LoadU(d, b + x + kRadius + i);
        add(0, a0 + a1);
        add(1, b0 + b1);
        add(2, a0 * a0 + a1 * a1);
        add(3, b0 * b0 + b1 * b1);
        add(4, a0 * b0 + a1 * b1);
      }
    }
    for (std::size_t k = 0; k < kNumMeans; ++k) hn::StoreU(sums[k], d, &moments.means[k][x]);
  });
}

void SimilarityOfRow(const SimilarityWindow& window,
                     const std::array<const RowMoments*, 2 * kRadius + 1>& rows,
                     const double* HWY_RESTRICT scale, int width, double* HWY_RESTRICT similarity) {
  ForEachPixel(width, [&](auto d, int x) {
    hn::Vec<decltype(d)> mean[kNumMeans];
    const auto normal = hn::LoadU(d, scale + x);
    for (std::size_t k = 0; k < kNumMeans; ++k) {
      auto sum = hn::Zero(d);
      for (int i = -kRadius; i <= kRadius; ++i) {
        const int place = i + kRadius;
        const RowMoments* row = rows[static_cast<std::size_t>(place)];
        if (row == nullptr) continue;
        const double weight = window.weights[static_cast<std::size_t>(i < 0 ? -i : i)];
        sum = sum + hn::Set(d, weight) * hn::LoadU(d, &row->means[k][x]);
      }
      mean[k] = sum * normal;
    }
    const auto aa = mean[0] * mean[0], bb = mean[1] * mean[1], ab = mean[0] * mean[1];
    const auto two = hn::Set(d, 2.0), c1 = hn::Set(d, kC1), c2 = hn::Set(d, kC2);
    const auto value = (two * ab + c1) * (two * (mean[4] - ab) + c2) /
                       ((aa + bb + c1) * ((mean[2] - aa) + (mean[3] - bb) + c2));
    hn::StoreU(value, d, similarity + x);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace {

HWY_EXPORT(HorizontalMoments);
HWY_EXPORT(SimilarityOfRow);

}  // namespace

SimilarityWindow::SimilarityWindow() : weights{} {
  constexpr double kSigma = 1.5;
  for (int i = 0; i <= kRadius; ++i) {
    weights[static_cast<std::size_t>(i)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  }
}

double SimilarityWindow::SumAt(int at, int size) const {
  double sum = 0;
  for (int i = -kRadius; i <= kRadius; ++i) {
    if (at + i >= 0 && at + i < size) sum += weights[static_cast<std::size_t>(i < 0 ? -i : i)];
  }
  return sum;
}

void HorizontalMoments(const SimilarityWindow& window, const double* a, const double* b, int width,
                       RowMoments& moments) {
  for (std::vector<double>& mean : moments.means) mean.resize(static_cast<std::size_t>(width));
  HWY_DYNAMIC_DISPATCH(HorizontalMoments)(window, a, b, width, moments);
}

void SimilarityOfRow(const SimilarityWindow& window,
                     const std::array<const RowMoments*, 2 * SimilarityWindow::kRadius + 1>& rows,
                     const double* scale, int width, double* similarity) {
  HWY_DYNAMIC_DISPATCH(SimilarityOfRow)(window, rows, scale, width, similarity);
}

}  // namespace lamella
#endif  // HWY_ONCE
