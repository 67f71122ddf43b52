#include "distribute/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr int kRadius = 5;  // of the SSIM window: 3.3 sigma
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;

void CheckSizes(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b, const MetricRegion& region) {
  const bool mask_fits = region.mask.data == nullptr ||
                         (region.mask.width == a.width && region.mask.height == a.height);
  if (a.width == b.width && a.height == b.height && mask_fits) return;
  throw UsageError("metrics",
                   fmt::format("pictures of {}x{} and {}x{} can't be compared", a.width, a.height,
                               b.width, b.height),
                   "resize one of them first");
}

struct Span {
  int first = 0, last = 0;  // [first, last)
};

Span Inner(int size, int border) {
  border = std::max(border, 0);
  return {std::min(border, size), std::max(size - border, 0)};
}

bool Counts(const MetricRegion& region, int x, int y) {
  return region.mask.data == nullptr || region.mask(x, y) >= 0.5F;
}

bool Contains(const Span& span, int at) { return at >= span.first && at < span.last; }

double Channel(const Rgb8& pixel, int channel) {
  const std::uint8_t code = channel == 0 ? pixel.r : channel == 1 ? pixel.g : pixel.b;
  constexpr double kPerCode = 1 / 255.0;
  return code * kPerCode;
}

// Weights of a window's pixels, from -kRadius to kRadius beside its centre.
using Window = std::array<double, 2 * kRadius + 1>;

// Where in a window the pixel `offset` beside its centre stands.
std::size_t PlaceOf(int offset) {
  const int place = offset + kRadius;
  return static_cast<std::size_t>(place);
}

// The window's weights for a pixel `at` of `size`, cut at the sides.
Window WindowWeights(int at, int size) {
  Window weights{};
  double sum = 0;
  for (int i = -kRadius; i <= kRadius; ++i) {
    if (at + i < 0 || at + i >= size) continue;
    const double w = std::exp(-0.5 * i * i / (kSigma * kSigma));
    weights[PlaceOf(i)] = w;
    sum += w;
  }
  for (double& w : weights) w /= sum;
  return weights;
}

struct Moments {  // means of a, b, a^2, b^2, ab over a window
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  void Add(double w, const Moments& m) {
    a += w * m.a;
    b += w * m.b;
    aa += w * m.aa;
    bb += w * m.bb;
    ab += w * m.ab;
  }
};

// Moments of one channel over the columns' windows of row y: the vertical half of the window.
std::vector<Moments> ColumnMoments(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b, int channel,
                                   int y) {
  const Window weights = WindowWeights(y, a.height);
  std::vector<Moments> moments(static_cast<std::size_t>(a.width));
  for (int i = -kRadius; i <= kRadius; ++i) {
    const double w = weights[PlaceOf(i)];
    if (w == 0) continue;
    for (int x = 0; x < a.width; ++x) {
      const double va = Channel(a(x, y + i), channel), vb = Channel(b(x, y + i), channel);
      moments[static_cast<std::size_t>(x)].Add(w, {va, vb, va * va, vb * vb, va * vb});
    }
  }
  return moments;
}

double Similarity(const Moments& m) {
  const double variance_a = m.aa - m.a * m.a, variance_b = m.bb - m.b * m.b;
  const double covariance = m.ab - m.a * m.b;
  return (2 * m.a * m.b + kC1) * (2 * covariance + kC2) /
         ((m.a * m.a + m.b * m.b + kC1) * (variance_a + variance_b + kC2));
}

struct Sum {
  double value = 0;
  std::int64_t count = 0;
};
using Sums = std::vector<Sum>;  // of each region

Sums SimilarityOfRow(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                     const std::vector<MetricRegion>& regions, int y,
                     const std::vector<Window>& weights) {
  Sums sums(regions.size());
  for (int channel = 0; channel < 3; ++channel) {
    const std::vector<Moments> moments = ColumnMoments(a, b, channel, y);
    for (int x = 0; x < a.width; ++x) {
      const auto counts = [&](const MetricRegion& region) {
        return Contains(Inner(a.width, region.border_px), x) &&
               Contains(Inner(a.height, region.border_px), y) && Counts(region, x, y);
      };
      if (std::none_of(regions.begin(), regions.end(), counts)) continue;
      Moments m;
      for (int i = -kRadius; i <= kRadius; ++i) {
        const double w = weights[static_cast<std::size_t>(x)][PlaceOf(i)];
        const int column = x + i;
        if (w != 0) m.Add(w, moments[static_cast<std::size_t>(column)]);
      }
      const double similarity = Similarity(m);
      for (std::size_t r = 0; r < regions.size(); ++r) {
        if (!counts(regions[r])) continue;
        sums[r].value += similarity;
        ++sums[r].count;
      }
    }
  }
  return sums;
}

}  // namespace

SquaredError SumSquaredError(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                             const MetricRegion& region) {
  CheckSizes(a, b, region);
  const Span columns = Inner(a.width, region.border_px), rows = Inner(a.height, region.border_px);
  std::int64_t squares = 0, count = 0;  // of codes: exact
  for (int y = rows.first; y < rows.last; ++y) {
    for (int x = columns.first; x < columns.last; ++x) {
      if (!Counts(region, x, y)) continue;
      const Rgb8 p = a(x, y), q = b(x, y);
      const int dr = p.r - q.r, dg = p.g - q.g, db = p.b - q.b;
      squares += dr * dr + dg * dg + db * db;
      count += 3;
    }
  }
  return {static_cast<double>(squares) / (255.0 * 255.0), count};
}

std::optional<double> Psnr(const SquaredError& error) {
  if (error.count == 0) return std::nullopt;
  if (error.sum == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(static_cast<double>(error.count) / error.sum);
}

std::optional<double> Psnr(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                           const MetricRegion& region) {
  return Psnr(SumSquaredError(a, b, region));
}

std::vector<std::optional<double>> SsimOfRegions(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                                                 const std::vector<MetricRegion>& regions) {
  Span rows{a.height, 0};
  for (const MetricRegion& region : regions) {
    CheckSizes(a, b, region);
    const Span inner = Inner(a.height, region.border_px);
    rows = {std::min(rows.first, inner.first), std::max(rows.last, inner.last)};
  }
  std::vector<Window> weights;
  for (int x = 0; x < a.width; ++x) weights.push_back(WindowWeights(x, a.width));
  std::vector<Sums> sums(static_cast<std::size_t>(a.height));
  ParallelFor(rows.first, std::max(rows.first, rows.last), 8,
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t y = first; y < last; ++y) {
                  sums[static_cast<std::size_t>(y)] =
                      SimilarityOfRow(a, b, regions, static_cast<int>(y), weights);
                }
              });
  std::vector<std::optional<double>> means;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    Sum total;
    for (const Sums& row : sums) {
      if (row.empty()) continue;
      total.value += row[r].value;
      total.count += row[r].count;
    }
    means.emplace_back();
    if (total.count > 0) means.back() = total.value / static_cast<double>(total.count);
  }
  return means;
}

std::optional<double> Ssim(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                           const MetricRegion& region) {
  return SsimOfRegions(a, b, {region})[0];
}

}  // namespace lamella
