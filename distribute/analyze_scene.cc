#include "distribute/analyze_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "lightfield/color.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr int kBins = 80;
constexpr int kBlock = 32, kHalf = kBlock / 2;
constexpr int kLeastBin = 2;  // coarser than that is no detail
constexpr double kQuantile = 0.01;
constexpr double kFarthest = 1e12;  // mm; stands for infinitely far

// Energy by the bin that limits it.
using Spectrum = std::array<double, kHalf + 1>;

struct Waves {
  std::array<double, kBlock> window;
  std::array<std::complex<double>, kBlock> turn;  // exp(-2 pi i k / 32)
};

Waves MakeWaves() {
  Waves waves;
  for (int i = 0; i < kBlock; ++i) {
    const double angle = 2 * std::numbers::pi * i / kBlock;
    waves.window[static_cast<std::size_t>(i)] = (1 - std::cos(angle)) / 2;
    waves.turn[static_cast<std::size_t>(i)] = std::polar(1.0, -angle);
  }
  return waves;
}

using Block = std::array<std::array<double, kBlock>, kBlock>;

Block WindowedBlock(const Waves& waves, ImageSpan<const Rgb> picture, int left, int top) {
  Block block;
  double sum = 0, weights = 0;
  for (std::size_t y = 0; y < kBlock; ++y) {
    for (std::size_t x = 0; x < kBlock; ++x) {
      block[y][x] = static_cast<double>(
          Luminance(picture(left + static_cast<int>(x), top + static_cast<int>(y))));
      sum += waves.window[x] * waves.window[y] * block[y][x];
      weights += waves.window[x] * waves.window[y];
    }
  }
  for (std::size_t y = 0; y < kBlock; ++y) {
    for (std::size_t x = 0; x < kBlock; ++x) {
      block[y][x] = waves.window[x] * waves.window[y] * (block[y][x] - sum / weights);
    }
  }
  return block;
}

// The bins kx = 0 ... 16 stand for the negative ones, too; kx = 0 and 16 are their own mirrors.
Spectrum SpectrumOf(const Waves& waves, const Block& block, int parallax_axes) {
  Spectrum spectrum{};
  std::array<std::complex<double>, kBlock> column;
  for (std::size_t kx = 0; kx <= kHalf; ++kx) {
    for (std::size_t y = 0; y < kBlock; ++y) {
      column[y] = 0;
      for (std::size_t x = 0; x < kBlock; ++x) {
        column[y] += block[y][x] * waves.turn[kx * x % kBlock];
      }
    }
    const double mirrors = kx == 0 || kx == kHalf ? 1 : 2;
    for (std::size_t ky = 0; ky < kBlock; ++ky) {
      std::complex<double> value = 0;
      for (std::size_t y = 0; y < kBlock; ++y) value += column[y] * waves.turn[ky * y % kBlock];
      const std::size_t finest = std::max(kx, std::min(ky, kBlock - ky));
      if (finest < kLeastBin) continue;
      spectrum[parallax_axes == 1 ? kx : finest] += mirrors * std::norm(value);
    }
  }
  return spectrum;
}

// Bin k holds the frequencies from k - 1/2 to k + 1/2.
double EnergyBelow(const Spectrum& spectrum, double limit) {
  double energy = 0;
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    energy += spectrum[k] * std::clamp(limit - (static_cast<double>(k) - 0.5), 0.0, 1.0);
  }
  return energy;
}

using CutoffAt = double (*)(const Display& display, double z_mm);

// The limit in bins for what is at z; negative where z is unknown.
Image<float> LimitsOf(const Display& display, CutoffAt cutoff, const Placement& placement,
                      ImageSpan<const float> depth) {
  Image<float> limits(depth.width, depth.height, -1);
  const double distance = placement.viewing_distance_mm;
  ParallelForEach(0, depth.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < depth.width; ++x) {
      if (!(depth(x, y) > 0)) continue;
      const double z = std::max(-kFarthest, placement.ZFromDepth(static_cast<double>(depth(x, y))));
      const double pixel = placement.mm_per_view_px * (distance - z) / distance;
      limits(x, y) = static_cast<float>(kBlock * pixel * cutoff(display, z));
    }
  });
  return limits;
}

// Kept by Eq. 1 and by the beams.
struct Detail {
  double kept = 0, kept_beam = 0, all = 0;
  Detail& operator+=(const Detail& other) {
    kept += other.kept;
    kept_beam += other.kept_beam;
    all += other.all;
    return *this;
  }
};

struct Limits {
  Image<float> lattice, beam;
};

Detail DetailOfBlock(const Spectrum& spectrum, const Limits& limits, ImageSpan<const Rgb> picture,
                     int left, int top) {
  const int width = limits.lattice.width(), height = limits.lattice.height();
  Detail detail;
  int known = 0;
  for (int y = top; y < top + kBlock; ++y) {
    for (int x = left; x < left + kBlock; ++x) {
      const int column = static_cast<int>((x + 0.5) * width / picture.width);
      const int row = static_cast<int>((y + 0.5) * height / picture.height);
      if (limits.lattice(column, row) < 0) continue;
      detail.kept += EnergyBelow(spectrum, static_cast<double>(limits.lattice(column, row)));
      detail.kept_beam += EnergyBelow(spectrum, static_cast<double>(limits.beam(column, row)));
      ++known;
    }
  }
  if (known == 0) return {};
  detail.kept /= known;
  detail.kept_beam /= known;
  for (const double energy : spectrum) detail.all += energy;
  return detail;
}

// Rows of blocks in parallel, added in their order.
Detail DetailOf(const Limits& limits, int parallax_axes, ImageSpan<const Rgb> picture) {
  const Waves waves = MakeWaves();
  const int rows = picture.height / kBlock, columns = picture.width / kBlock;
  std::vector<Detail> of_row(static_cast<std::size_t>(rows));
  ParallelForEach(0, rows, [&](std::int64_t row) {
    for (int column = 0; column < columns; ++column) {
      const int left = column * kBlock, top = static_cast<int>(row) * kBlock;
      const Block block = WindowedBlock(waves, picture, left, top);
      of_row[static_cast<std::size_t>(row)] +=
          DetailOfBlock(SpectrumOf(waves, block, parallax_axes), limits, picture, left, top);
    }
  });
  Detail sum;
  for (const Detail& detail : of_row) sum += detail;
  return sum;
}

void AddHistogram(const Analysis& analysis, std::vector<double>& known, SceneFigures& figures) {
  const double from = analysis.depths_mm.front(), to = analysis.depths_mm.back();
  for (int i = 0; i <= kBins; ++i) figures.edges_mm.push_back(from + (to - from) * i / kBins);
  figures.share.assign(kBins, 0);
  if (known.empty()) return;
  const double one = 1 / static_cast<double>(known.size());
  for (const double z : known) {
    if (z < from) {
      figures.share_behind += one;
    } else if (z > to) {
      figures.share_before += one;
    } else {
      const double bin = (z - from) / (to - from) * kBins;
      figures.share[static_cast<std::size_t>(std::min(bin, kBins - 1.0))] += one;
    }
    for (const DepthInterval& interval : analysis.sharp) {
      if (interval.Contains(z)) figures.sharp_share += one;
    }
  }
  std::sort(known.begin(), known.end());
  const auto quantile = [&](double q) {
    return known[static_cast<std::size_t>(q * static_cast<double>(known.size() - 1))];
  };
  figures.far_mm = quantile(kQuantile);
  figures.near_mm = quantile(1 - kQuantile);
}

}  // namespace

SceneFigures AnalyzeScene(const Display& display, const Analysis& analysis,
                          const Placement& placement, ImageSpan<const Rgb> picture,
                          ImageSpan<const float> depth) {
  SceneFigures figures;
  std::vector<double> known;
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      if (depth(x, y) > 0) {
        known.push_back(placement.ZFromDepth(static_cast<double>(depth(x, y))));
      }
    }
  }
  const double pixels = 1.0 * depth.width * depth.height;
  if (pixels > 0) figures.known_share = static_cast<double>(known.size()) / pixels;
  AddHistogram(analysis, known, figures);
  const Limits limits{LimitsOf(display, CombinedCutoffPerMm, placement, depth),
                      LimitsOf(display, CombinedBeamCutoffPerMm, placement, depth)};
  const Detail detail = DetailOf(limits, analysis.parallax_axes, picture);
  if (detail.all > 0) {
    figures.detail_kept = detail.kept / detail.all;
    figures.detail_kept_beam = detail.kept_beam / detail.all;
  }
  return figures;
}

}  // namespace lamella
