// Work goes by tiles of the reference; within one, by label, arm and source. Everything is
// 16-bit integers, so every target gives the same bytes:
//   planes: code * 128; filter taps: Q14; resampled values: code * 64; costs: 1/16 code.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/grid_cost.cc"
#include "depth/grid_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "depth/store_labels-inl.h"
#include "lightfield/parallel.h"

#ifndef LAMELLA_DEPTH_GRID_COST_SHARED
#define LAMELLA_DEPTH_GRID_COST_SHARED
namespace lamella {
namespace grid_cost {

constexpr int kTileColumns = 512, kTileRows = 16;
constexpr int kTileLabels = 16;  // so many codes of a pixel are written at once
constexpr int kSlack = 64;       // values that whole vectors may run over
constexpr int kMargin = 4;       // where a row buffer's x = tile.x lies
constexpr int kRowSize = kTileColumns + 2 * kMargin + kSlack;

constexpr std::int16_t kColorLimit = 3 * 20 * 64;  // of |dR| + |dG| + |dB|
constexpr std::int16_t kColorWeight = 819;  // Q15: 1/40, to 1/16 code with weight 0.1 a channel
constexpr std::int16_t kGradientLimit = 10 * 64;  // 1/64 code is 1/16 code with weight 4
// Q15, halved: of 38, 75 and 15 parts of 128.
constexpr std::int16_t kLumaRed = 4864, kLumaGreen = 9600, kLumaBlue = 1920;
// Codes are 6 times the mean sample: sum of quarter boxes * (kMeanFactor / sources) >> 16.
constexpr int kMeanFactor = 65536 * 4 * 6 / (9 * 16);
constexpr int kColorCost = 96, kGradientCost = 640;  // largest, 1/16 code

// A shift by `pixels` + a fraction whose Catmull-Rom weights (Q14) are `taps`.
struct Shift {
  explicit Shift(double shift) {
    const double whole = std::floor(shift);
    const double f = shift - whole;
    pixels = static_cast<int>(whole);
    const double w[4] = {f * (-0.5 + f * (1 - 0.5 * f)), 1 + f * f * (-2.5 + 1.5 * f),
                         f * (0.5 + f * (2 - 1.5 * f)), f * f * (-0.5 + 0.5 * f)};
    for (int i = 0; i < 4; ++i) taps[i] = static_cast<std::int16_t>(std::lround(w[i] * 16384));
  }
  int pixels = 0;
  std::int16_t taps[4] = {};
};

// First and one past the last integer x for which x + shift is within [-0.5, size - 0.5].
struct Interval {
  int begin, end;
};
inline Interval Inside(double shift, int size, const Interval& within) {
  const double begin = std::ceil(-0.5 - shift), end = std::floor(size - 0.5 - shift) + 1;
  const auto clamped = [&](double v) {
    return static_cast<int>(
        std::clamp(v, static_cast<double>(within.begin), static_cast<double>(within.end)));
  };
  return {clamped(begin), clamped(end)};
}

struct Tile {
  Rect rect;
  // Samples are needed one pixel around the tile, within the image.
  Interval columns, rows;
};

// Sums of one arm's samples: rows and columns of the tile with one neighbour on each side.
struct ArmSums {
  std::array<std::uint16_t, static_cast<std::size_t>((kTileRows + 2) * kRowSize)> values;
  std::uint16_t* Row(int r) { return values.data() + (r + 1) * kRowSize + kMargin; }
};

struct Scratch {
  std::array<ArmSums, kMaxArms> arms;
  // Rows of one source by row & 3: shifted along x, half luma differences, colour costs.
  std::array<std::array<std::array<std::int16_t, kRowSize>, 4>, 3> shifted;
  std::array<std::array<std::int16_t, kRowSize>, 4> luma;
  std::array<std::array<std::int16_t, kRowSize>, 4> color;
  std::array<std::uint8_t, static_cast<std::size_t>(kTileLabels* kTileRows* kTileColumns)> codes;
  std::array<std::array<std::uint16_t, kTileColumns + kSlack>, kMaxArms>
      boxes;  // a quarter of the 3x3 sum
  std::array<std::uint16_t, kRowSize> sums, best;
};

struct Job {
  const GridImage& reference;
  const std::vector<GridArm>& arms;
  const DisparityLabels& labels;
};

// A source's rows at a label, as pointers whose index 0 is the reference's column `x`.
using Taps = std::array<const std::int16_t*, 4>;

}  // namespace grid_cost
}  // namespace lamella
#endif  // LAMELLA_DEPTH_GRID_COST_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace grid_cost {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using lamella::HWY_NAMESPACE::StoreLabels;

using Codes = hn::ScalableTag<std::int16_t>;
using Costs = hn::ScalableTag<std::uint16_t>;
using CodeVec = hn::Vec<Codes>;

struct FilterWeights {
  explicit FilterWeights(const Shift& shift)
      : a(hn::Set(Codes(), shift.taps[0])),
        b(hn::Set(Codes(), shift.taps[1])),
        c(hn::Set(Codes(), shift.taps[2])),
        d(hn::Set(Codes(), shift.taps[3])) {}
  CodeVec a, b, c, d;
};

inline CodeVec Filter(const Taps& in, int i, const FilterWeights& w) {
  const Codes d;
  const auto first = hn::MulFixedPoint15(hn::LoadU(d, in[0] + i), w.a) +
                     hn::MulFixedPoint15(hn::LoadU(d, in[1] + i), w.b);
  const auto second = hn::MulFixedPoint15(hn::LoadU(d, in[2] + i), w.c) +
                      hn::MulFixedPoint15(hn::LoadU(d, in[3] + i), w.d);
  return first + second;
}

// All rows below are computed in whole vectors: they may run on to kSlack values past `count`.

void FilterRow(const Taps& in, const Shift& shift, int count, std::int16_t* HWY_RESTRICT out) {
  const Codes d;
  const FilterWeights weights(shift);
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    hn::StoreU(Filter(in, i, weights), d, out + i);
  }
}

// A source's filtered value minus the reference's. kTwice: the input is code * 64, of a first pass.
template <bool kTwice>
inline CodeVec Difference(const Taps& in, const std::int16_t* reference, int i,
                          const FilterWeights& weights) {
  const Codes d;
  auto value = Filter(in, i, weights);
  if (kTwice) value = value + value;
  return value - hn::ShiftRight<1>(hn::LoadU(d, reference + i));
}

// Half the luma difference to the reference.
template <bool kTwice>
void LumaRow(const Taps& in, const std::int16_t* reference, const Shift& shift, int count,
             std::int16_t* HWY_RESTRICT luma) {
  const Codes d;
  const FilterWeights weights(shift);
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    hn::StoreU(hn::ShiftRight<1>(Difference<kTwice>(in, reference, i, weights)), d, luma + i);
  }
}

// Of three colour planes: half the luma difference, and the colour part of the cost.
template <bool kTwice>
void ColorRow(const std::array<Taps, 3>& in, const std::array<const std::int16_t*, 3>& reference,
              const Shift& shift, int count, std::int16_t* HWY_RESTRICT luma,
              std::int16_t* HWY_RESTRICT color) {
  const Codes d;
  const FilterWeights weights(shift);
  const auto limit = hn::Set(d, kColorLimit), factor = hn::Set(d, kColorWeight);
  const auto red = hn::Set(d, kLumaRed), green = hn::Set(d, kLumaGreen),
             blue = hn::Set(d, kLumaBlue);
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const auto r = Difference<kTwice>(in[0], reference[0], i, weights);
    const auto g = Difference<kTwice>(in[1], reference[1], i, weights);
    const auto b = Difference<kTwice>(in[2], reference[2], i, weights);
    hn::StoreU(
        hn::MulFixedPoint15(r, red) + hn::MulFixedPoint15(g, green) + hn::MulFixedPoint15(b, blue),
        d, luma + i);
    const auto sum =
        hn::Min(hn::Abs(r), limit) + hn::Min(hn::Abs(g), limit) + hn::Min(hn::Abs(b), limit);
    hn::StoreU(hn::MulFixedPoint15(hn::Min(sum, limit), factor), d, color + i);
  }
}

// Adds the samples of `count` pixels, no more, to the arm's sums.
void AddSamples(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below,
                const std::int16_t* color, int count, std::uint16_t* HWY_RESTRICT sums) {
  const Codes d;
  const Costs costs;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto limit = hn::Set(d, kGradientLimit);
  for (int i = 0; i < count; i += lanes) {
    const auto gx = hn::LoadU(d, here + i + 1) - hn::LoadU(d, here + i - 1);
    const auto gy = hn::LoadU(d, below + i) - hn::LoadU(d, above + i);
    const auto gradient = hn::Min(hn::Abs(gx), limit) + hn::Min(hn::Abs(gy), limit);
    const auto cost = hn::LoadU(d, color + i) + hn::Min(gradient, limit);
    const auto sum = hn::LoadU(costs, sums + i) + hn::BitCast(costs, cost);
    if (i + lanes <= count) {
      hn::StoreU(sum, costs, sums + i);
    } else {
      hn::BlendedStore(sum, hn::FirstN(costs, static_cast<std::size_t>(count - i)), costs,
                       sums + i);
    }
  }
}

inline void AddConstant(std::uint16_t* sums, int begin, int end, int value) {
  for (int i = begin; i < end; ++i) sums[i] = static_cast<std::uint16_t>(sums[i] + value);
}

// One source at one label: the differences of its shifted rows to the reference's.
class SourceRows {
 public:
  SourceRows(const GridImage& reference, const GridSource& source, double disparity,
             const Interval& columns, Scratch& scratch)
      : reference_(reference),
        image_(*source.image),
        along_x_(-disparity * source.columns),
        along_y_(-disparity * source.rows),
        two_passes_(source.columns != 0 && source.rows != 0),
        vertical_(source.rows != 0),
        begin_(columns.begin - 1),
        count_(columns.end + 1 - begin_),
        scratch_(scratch) {}

  // Half luma differences (and colour costs) of reference row y into the rings at y & 3.
  // Called for rising y.
  void Compute(int y, int offset) {
    const std::size_t ring = static_cast<std::size_t>(y & 3);
    std::int16_t* luma = scratch_.luma[ring].data() + offset + begin_;
    std::array<Taps, 3> taps;
    std::array<const std::int16_t*, 3> reference{};
    for (int plane = 0; plane < image_.num_planes(); ++plane) {
      const auto p = static_cast<std::size_t>(plane);
      taps[p] = RowTaps(plane, y, offset);
      reference[p] = reference_.Row(plane, y) + begin_;
    }
    const Shift& shift = vertical_ ? along_y_ : along_x_;
    std::int16_t* color = scratch_.color[ring].data() + offset + begin_;
    if (image_.color()) {
      const auto row = two_passes_ ? ColorRow<true> : ColorRow<false>;
      row(taps, reference, shift, count_, luma, color);
    } else {
      const auto row = two_passes_ ? LumaRow<true> : LumaRow<false>;
      row(taps[0], reference[0], shift, count_, luma);
    }
  }

 private:
  // The four inputs of the last filter.
  Taps RowTaps(int plane, int y, int offset) {
    if (!vertical_) return ShiftedTaps(plane, y);
    Taps taps;
    for (int i = 0; i < 4; ++i) {
      const int row = y + along_y_.pixels - 1 + i;
      taps[static_cast<std::size_t>(i)] =
          two_passes_ ? ShiftedRow(plane, row, offset) : image_.Row(plane, row) + begin_;
    }
    return taps;
  }
  Taps ShiftedTaps(int plane, int row) const {
    const std::int16_t* first = image_.Row(plane, row) + begin_ + along_x_.pixels - 1;
    return {first, first + 1, first + 2, first + 3};
  }
  // A row shifted along x, from the ring: each is made once.
  const std::int16_t* ShiftedRow(int plane, int row, int offset) {
    const auto p = static_cast<std::size_t>(plane);
    std::int16_t* out =
        scratch_.shifted[p][static_cast<std::size_t>(row & 3)].data() + offset + begin_;
    if (row > last_row_[p]) {
      FilterRow(ShiftedTaps(plane, row), along_x_, count_, out);
      last_row_[p] = row;
    }
    return out;
  }

  const GridImage& reference_;
  const GridImage& image_;
  Shift along_x_, along_y_;
  bool two_passes_, vertical_;
  int begin_, count_;
  Scratch& scratch_;
  std::array<int, 3> last_row_{-(1 << 30), -(1 << 30), -(1 << 30)};
};

void AddSource(const Job& job, const GridSource& source, double disparity, const Tile& tile,
               ArmSums& arm, Scratch& scratch) {
  const GridImage& image = *source.image;
  const Interval columns = Inside(-disparity * source.columns, image.width(), tile.columns);
  const Interval rows = Inside(-disparity * source.rows, image.height(), tile.rows);
  const bool seen = columns.begin < columns.end && rows.begin < rows.end;
  const int outside = (image.color() ? kColorCost + kGradientCost : kGradientCost) / 2;
  const int x0 = tile.rect.x, offset = kMargin - x0;
  const int from = tile.columns.begin - x0, to = tile.columns.end - x0;
  for (int y = tile.rows.begin; y < tile.rows.end; ++y) {
    std::uint16_t* sums = arm.Row(y - tile.rect.y);
    if (!seen || y < rows.begin || y >= rows.end) {
      AddConstant(sums, from, to, outside);
    } else {
      AddConstant(sums, from, columns.begin - x0, outside);
      AddConstant(sums, columns.end - x0, to, outside);
    }
  }
  if (!seen) return;
  SourceRows source_rows(job.reference, source, disparity, columns, scratch);
  for (int y = rows.begin - 1; y <= rows.end; ++y) {
    source_rows.Compute(y, offset);
    if (y <= rows.begin) continue;
    const auto ring = [&](int row) { return static_cast<std::size_t>(row & 3); };
    const int at = columns.begin + offset;
    AddSamples(scratch.luma[ring(y - 2)].data() + at, scratch.luma[ring(y - 1)].data() + at,
               scratch.luma[ring(y)].data() + at, scratch.color[ring(y - 1)].data() + at,
               columns.end - columns.begin, arm.Row(y - 1 - tile.rect.y) + columns.begin - x0);
  }
}

// The tile's neighbours that lie outside of the image repeat its edge.
void RepeatEdges(const Tile& tile, ArmSums& arm) {
  const int width = tile.rect.width, height = tile.rect.height;
  for (int y = tile.rows.begin - tile.rect.y; y < tile.rows.end - tile.rect.y; ++y) {
    std::uint16_t* row = arm.Row(y);
    if (tile.columns.begin == tile.rect.x) row[-1] = row[0];
    if (tile.columns.end == tile.rect.x + width) row[width] = row[width - 1];
  }
  const std::size_t bytes = static_cast<std::size_t>(width + 2) * sizeof(std::uint16_t);
  if (tile.rows.begin == tile.rect.y) std::memcpy(arm.Row(-1) - 1, arm.Row(0) - 1, bytes);
  if (tile.rows.end == tile.rect.y + height)
    std::memcpy(arm.Row(height) - 1, arm.Row(height - 1) - 1, bytes);
}

void BoxRow(ArmSums& arm, int y, int width, std::uint16_t* HWY_RESTRICT sums,
            std::uint16_t* HWY_RESTRICT box) {
  const Costs d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const std::uint16_t *a = arm.Row(y - 1), *b = arm.Row(y), *c = arm.Row(y + 1);
  for (int x = -1; x <= width; x += lanes) {
    hn::StoreU(hn::LoadU(d, a + x) + hn::LoadU(d, b + x) + hn::LoadU(d, c + x), d, sums + x);
  }
  for (int x = 0; x < width; x += lanes) {
    const auto sum =
        hn::LoadU(d, sums + x - 1) + hn::LoadU(d, sums + x) + hn::LoadU(d, sums + x + 1);
    hn::StoreU(hn::ShiftRight<2>(sum), d, box + x);
  }
}

// Lowers `best` to the mean over some arms.
void LowerToMean(const std::uint16_t* const* boxes, std::size_t arms, int factor, int width,
                 std::uint16_t* HWY_RESTRICT best) {
  const Costs d;
  const auto scale = hn::Set(d, static_cast<std::uint16_t>(factor));
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(d))) {
    auto sum = hn::LoadU(d, boxes[0] + x);
    for (std::size_t a = 1; a < arms; ++a) sum = sum + hn::LoadU(d, boxes[a] + x);
    hn::StoreU(hn::Min(hn::LoadU(d, best + x), hn::MulHigh(sum, scale)), d, best + x);
  }
}

// Best contiguous half of the arms, as codes of one row.
void BestHalf(const Job& job, int width, Scratch& scratch, std::uint8_t* HWY_RESTRICT codes) {
  const std::size_t sides = job.arms.size();
  std::uint16_t* best = scratch.best.data();
  std::fill(best, best + width + kSlack, std::uint16_t{CostVolume::kMaxCost});
  for (std::size_t first = 0; first < sides; ++first) {
    const std::uint16_t* boxes[kMaxArms];
    std::size_t arms = 0, sources = 0;
    for (std::size_t i = 0; i < sides / 2; ++i) {
      const std::size_t side = (first + i) % sides;
      if (job.arms[side].empty()) continue;
      boxes[arms++] = scratch.boxes[side].data();
      sources += job.arms[side].size();
    }
    if (arms > 0) LowerToMean(boxes, arms, kMeanFactor / static_cast<int>(sources), width, best);
  }
  for (int x = 0; x < width; ++x) codes[x] = static_cast<std::uint8_t>(best[x]);
}

void CostOfTile(const Job& job, const Tile& tile, Scratch& scratch, CostVolume& volume) {
  const int width = tile.rect.width;
  for (auto& row : scratch.color) row.fill(0);
  for (int first = 0; first < job.labels.count; first += kTileLabels) {
    const int labels = std::min(kTileLabels, job.labels.count - first);
    for (int i = 0; i < labels; ++i) {
      const double disparity = job.labels.Disparity(first + i);
      for (std::size_t a = 0; a < job.arms.size(); ++a) {
        if (job.arms[a].empty()) continue;
        scratch.arms[a].values.fill(0);
        for (const GridSource& source : job.arms[a]) {
          AddSource(job, source, disparity, tile, scratch.arms[a], scratch);
        }
        RepeatEdges(tile, scratch.arms[a]);
      }
      for (int y = 0; y < tile.rect.height; ++y) {
        for (std::size_t a = 0; a < job.arms.size(); ++a) {
          if (job.arms[a].empty()) continue;
          BoxRow(scratch.arms[a], y, width, scratch.sums.data() + kMargin, scratch.boxes[a].data());
        }
        BestHalf(job, width, scratch, scratch.codes.data() + (i * kTileRows + y) * kTileColumns);
      }
    }
    StoreLabels(scratch.codes.data(), kTileColumns, kTileRows * kTileColumns, tile.rect, first,
                labels, volume);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace grid_cost
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace grid_cost {
HWY_EXPORT(CostOfTile);

std::vector<Tile> TilesOf(int width, int height) {
  std::vector<Tile> tiles;
  for (int y = 0; y < height; y += kTileRows) {
    for (int x = 0; x < width; x += kTileColumns) {
      const Rect rect{x, y, std::min(kTileColumns, width - x), std::min(kTileRows, height - y)};
      tiles.push_back({rect,
                       {std::max(0, x - 1), std::min(width, x + rect.width + 1)},
                       {std::max(0, y - 1), std::min(height, y + rect.height + 1)}});
    }
  }
  return tiles;
}

}  // namespace grid_cost

GridImage::GridImage(ImageSpan<const Rgb8> image, bool color)
    : width_(image.width),
      height_(image.height),
      num_planes_(color ? 3 : 1),
      stride_(image.width + 2 * kBorder),
      values_(static_cast<std::size_t>(num_planes_) * static_cast<std::size_t>(stride_) *
                  static_cast<std::size_t>(image.height + 2 * kBorder) +
              grid_cost::kSlack) {
  std::int16_t* out = values_.data();
  for (int plane = 0; plane < num_planes_; ++plane) {
    for (int y = -kBorder; y < height_ + kBorder; ++y) {
      const Rgb8* row = image.row(std::clamp(y, 0, height_ - 1));
      for (int x = -kBorder; x < width_ + kBorder; ++x) {
        const Rgb8 p = row[std::clamp(x, 0, width_ - 1)];
        const int luma128 = 38 * p.r + 75 * p.g + 15 * p.b;
        const int code128 = kScale * (plane == 0 ? p.r : plane == 1 ? p.g : p.b);
        *out++ = static_cast<std::int16_t>(color ? code128 : luma128);
      }
    }
  }
}

const std::int16_t* GridImage::Row(int plane, int y) const {
  const int rows = height_ + 2 * kBorder;
  const int row = plane * rows + std::clamp(y + kBorder, 0, rows - 1);
  return values_.data() + row * stride_ + kBorder;
}

CostVolume GridCost(const GridImage& reference, const std::vector<GridArm>& arms,
                    const DisparityLabels& labels, VolumeBytes memory) {
  using namespace grid_cost;  // NOLINT
  CostVolume volume(reference.width(), reference.height(), labels.count, std::move(memory));
  const std::vector<Tile> tiles = TilesOf(reference.width(), reference.height());
  const Job job{reference, arms, labels};
  ParallelForEach(0, static_cast<std::int64_t>(tiles.size()), [&](std::int64_t i) {
    const auto scratch = std::make_unique<Scratch>();
    HWY_DYNAMIC_DISPATCH(CostOfTile)(job, tiles[static_cast<std::size_t>(i)], *scratch, volume);
  });
  return volume;
}

}  // namespace lamella
#endif  // HWY_ONCE
