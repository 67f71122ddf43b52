#include "datasets_synthetic/lens_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace lamella {
namespace {

using Pairs = std::vector<std::array<const float*, 2>>;  // one for each weight

template <std::size_t kCount>
void WeighSome(const std::vector<float>& weights, const Pairs& pairs, std::size_t first,
               float* sums) {
  std::array<float, kCount> sum{};
  for (std::size_t m = 0; m < weights.size(); ++m) {
    const float *a = pairs[m][0] + first, *b = pairs[m][1] + first, weight = weights[m];
    for (std::size_t i = 0; i < kCount; ++i) sum[i] += weight * (a[i] + b[i]);
  }
  std::copy(sum.begin(), sum.end(), sums + first);
}

// The sum of each weight times its pair, for as many numbers as registers hold at once.
void WeighPairs(const std::vector<float>& weights, const Pairs& pairs, std::size_t count,
                float* sums) {
  constexpr std::size_t kAtOnce = 16;
  std::size_t i = 0;
  for (; i + kAtOnce <= count; i += kAtOnce) WeighSome<kAtOnce>(weights, pairs, i, sums);
  for (; i < count; ++i) WeighSome<1>(weights, pairs, i, sums);
}

}  // namespace

LensSpread::LensSpread(double sigma_px) {
  const double sigma = kSide * sigma_px;
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  const auto gaussian = [&](int k) {
    return k > reach ? 0 : std::exp(-0.5 * k * k / sigma / sigma);
  };
  double total = 0;
  for (int k = -reach; k <= reach; ++k) total += gaussian(std::abs(k));
  for (int m = 0; m <= reach; ++m) {
    weights_.push_back(static_cast<float>((gaussian(m) + gaussian(m + 1)) / (2 * total)));
  }
}

// Pixel x has the half pixels 2x and 2x + 1, and in step m 2x - m and 2x + 1 + m. Even and odd ones
// are laid in rows of their own, so that those of neighbouring pixels are neighbours.
void LensSpread::AlongX(const Rgb* half_pixels, int width, Rgb* pixels) const {
  const int room = reach() / 2 + 1, last = kSide * width - 1;
  std::array<std::vector<Rgb>, kSide> parity;
  for (int p = 0; p < kSide; ++p) {
    std::vector<Rgb>& row = parity[static_cast<std::size_t>(p)];
    row.reserve(static_cast<std::size_t>(width) + 2 * static_cast<std::size_t>(room));
    row.assign(static_cast<std::size_t>(room), half_pixels[0]);
    for (int x = p; x <= last; x += kSide) row.push_back(half_pixels[x]);
    row.insert(row.end(), static_cast<std::size_t>(room), half_pixels[last]);
  }
  const auto from = [&](int p, int x) {
    return &(parity[static_cast<std::size_t>(p)].data() + room + x)->r;
  };
  Pairs pairs;
  for (int m = 0; m <= reach(); ++m) {
    const int odd = m % 2, steps = (m + odd) / 2;
    pairs.push_back({from(odd, -steps), from(1 - odd, steps)});
  }
  WeighPairs(weights_, pairs, 3 * static_cast<std::size_t>(width), &pixels->r);
}

void LensSpread::AlongY(const Image<Rgb>& rows, int first, int height, int y, Rgb* pixels) const {
  Pairs pairs;
  for (int m = 0; m <= reach(); ++m) {
    pairs.push_back({&rows.row(std::max(kSide * y - m, 0) - first)->r,
                     &rows.row(std::min(kSide * y + 1 + m, height - 1) - first)->r});
  }
  WeighPairs(weights_, pairs, 3 * static_cast<std::size_t>(rows.width()), &pixels->r);
}

}  // namespace lamella
