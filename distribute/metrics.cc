#include "distribute/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "distribute/similarity_kernels.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr int kRadius = SimilarityWindow::kRadius;
constexpr int kRowsAtOnce = 64;  // of those above and below, 2 kRadius are computed twice

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

struct Sum {
  double value = 0;
  std::int64_t count = 0;
};
using Sums = std::vector<Sum>;  // of each region

// The similarity of one channel, row after row: moments of the rows around are kept.
class ChannelSimilarity {
 public:
  ChannelSimilarity(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b, int channel)
      : a_(a), b_(b), channel_(channel), similarity_(static_cast<std::size_t>(a.width)) {
    for (int x = 0; x < a.width; ++x) column_sums_.push_back(window_.SumAt(x, a.width));
  }

  // For rising rows only.
  const std::vector<double>& OfRow(int y) {
    next_ = std::max(next_, std::max(y - kRadius, 0));
    for (; next_ <= std::min(y + kRadius, a_.height - 1); ++next_) Enter(next_);
    std::array<const RowMoments*, kRing> rows{};
    for (int i = -kRadius; i <= kRadius; ++i) {
      if (y + i >= 0 && y + i < a_.height) rows[PlaceOf(i + kRadius)] = &ring_[PlaceOf(y + i)];
    }
    std::vector<double> scale;
    const double rows_sum = window_.SumAt(y, a_.height);
    for (const double columns_sum : column_sums_) scale.push_back(1 / (rows_sum * columns_sum));
    SimilarityOfRow(window_, rows, scale.data(), a_.width, similarity_.data());
    return similarity_;
  }

 private:
  static constexpr std::size_t kRing = 2 * kRadius + 1;
  static std::size_t PlaceOf(int row) { return static_cast<std::size_t>(row) % kRing; }

  void Enter(int y) {
    const auto padded = [&](ImageSpan<const Rgb8> picture) {
      std::vector<double> row(static_cast<std::size_t>(a_.width + 2 * kRadius), 0.0);
      double* of_picture = row.data() + kRadius;
      for (int x = 0; x < a_.width; ++x) of_picture[x] = Channel(picture(x, y), channel_);
      return row;
    };
    HorizontalMoments(window_, padded(a_).data(), padded(b_).data(), a_.width, ring_[PlaceOf(y)]);
  }

  const SimilarityWindow window_;
  ImageSpan<const Rgb8> a_, b_;
  int channel_;
  int next_ = 0;  // the first row whose moments are not in the ring yet
  std::array<RowMoments, kRing> ring_;
  std::vector<double> column_sums_;  // of the window's weights, by column
  std::vector<double> similarity_;
};

void AddRow(const std::vector<double>& similarity, const std::vector<MetricRegion>& regions,
            int height, int y, Sums& sums) {
  const int width = static_cast<int>(similarity.size());
  for (std::size_t r = 0; r < regions.size(); ++r) {
    if (!Contains(Inner(height, regions[r].border_px), y)) continue;
    const Span columns = Inner(width, regions[r].border_px);
    for (int x = columns.first; x < columns.last; ++x) {
      if (!Counts(regions[r], x, y)) continue;
      sums[r].value += similarity[static_cast<std::size_t>(x)];
      ++sums[r].count;
    }
  }
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
  std::vector<Sums> sums(static_cast<std::size_t>(a.height), Sums(regions.size()));
  ParallelFor(rows.first, std::max(rows.first, rows.last), kRowsAtOnce,
              [&](std::int64_t first, std::int64_t last) {
                for (int channel = 0; channel < 3; ++channel) {
                  ChannelSimilarity similarity(a, b, channel);
                  for (int y = static_cast<int>(first); y < last; ++y) {
                    AddRow(similarity.OfRow(y), regions, a.height, y,
                           sums[static_cast<std::size_t>(y)]);
                  }
                }
              });
  std::vector<std::optional<double>> means;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    Sum total;
    for (const Sums& row : sums) {
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
