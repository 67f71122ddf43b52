// Work goes by tiles of the reference; within one, by label and source. Coordinates are 32-bit
// floats without fused operations, all else is integers, so every target gives the same bytes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/plane_sweep.cc"
#include "depth/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <utility>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "depth/store_labels-inl.h"
#include "lightfield/parallel.h"

#ifndef LAMELLA_DEPTH_PLANE_SWEEP_SHARED
#define LAMELLA_DEPTH_PLANE_SWEEP_SHARED
namespace lamella {
namespace plane_sweep {

constexpr int kTileColumns = 256, kTileRows = 32;
constexpr int kTileLabels = 16;        // so many codes of a pixel are written at once
constexpr int kBox = 1, kCensus = 2;   // radii
constexpr int kHalo = kBox + kCensus;  // px around a tile that are warped
constexpr int kSlack = 64;             // values that whole vectors may run over
constexpr int kRowSize = kTileColumns + 2 * kHalo + kSlack;
constexpr int kWarpRows = kTileRows + 2 * kHalo, kCensusRows = kTileRows + 2 * kBox;
constexpr int kNeighbours = 24;         // of the census
constexpr int kUnseen = 14;             // distance where the source does not see the point
constexpr float kNearestDepth = 1e-6F;  // of a plane before a source, in its own scale

using Row = std::array<std::uint8_t, kRowSize>;

// Warped luma: 1..255, 0 where the source does not see the point. Row r, column c are at reference
// pixel (tile.x + c - kHalo, tile.y + r - kHalo).
using Warped = std::array<Row, kWarpRows>;
// 255 where the neighbour is brighter than the pixel; row r, column c are at reference pixel
// (tile.x + c - kBox, tile.y + r - kBox).
using CensusPlanes = std::array<std::array<Row, kNeighbours>, kCensusRows>;

struct Scratch {
  Warped warped;
  CensusPlanes census;  // of the reference
  std::array<std::array<Row, kCensusRows>, kMaxSweepSources> distance;
  std::array<Row, kCensusRows> best;  // sum over the better half
  std::array<std::uint8_t, static_cast<std::size_t>(kTileLabels* kTileRows* kTileColumns)> codes;
  std::array<std::uint16_t, kRowSize> column_sums;
};

// Homogeneous source coordinates along a row: at reference pixel x + i, (base + i step)[k]; the
// first two times 64.
struct RowWarp {
  std::array<float, 3> base, step;
  float limit_x, limit_y;  // 64 * (size - 0.5), of index coordinates
  float last_x, last_y;    // 64 * (size - 1)
  const std::uint32_t* quads;
  int stride;
};

inline RowWarp WarpOfRow(const SweepSource& source, double w, int x, int y) {
  const Eigen::Vector3d start = source.m * Eigen::Vector3d(x + 0.5, y + 0.5, 1) + w * source.b;
  const Eigen::Vector3d along = source.m.col(0);
  RowWarp warp{};
  for (int k = 0; k < 3; ++k) {
    const double scale = k < 2 ? 64 : 1;
    warp.base[static_cast<std::size_t>(k)] = static_cast<float>(scale * start[k]);
    warp.step[static_cast<std::size_t>(k)] = static_cast<float>(scale * along[k]);
  }
  const auto width = static_cast<float>(source.image->width()),
             height = static_cast<float>(source.image->height());
  warp.limit_x = 64 * (width - 0.5F);
  warp.limit_y = 64 * (height - 0.5F);
  warp.last_x = 64 * (width - 1);
  warp.last_y = 64 * (height - 1);
  warp.quads = source.image->quads();
  warp.stride = source.image->width();
  return warp;
}

}  // namespace plane_sweep
}  // namespace lamella
#endif  // LAMELLA_DEPTH_PLANE_SWEEP_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace plane_sweep {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using lamella::HWY_NAMESPACE::StoreLabels;

using Bytes = hn::ScalableTag<std::uint8_t>;
using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::ScalableTag<std::uint16_t>;

#if HWY_TARGET == HWY_SCALAR
// Bilinear from the four bytes with 6-bit weights.
inline hn::Vec<Ints> Blend(hn::Vec<Ints> quads, hn::Vec<Ints> wx, hn::Vec<Ints> wy) {
  const auto q = static_cast<std::uint32_t>(hn::GetLane(quads));
  const int x = hn::GetLane(wx), y = hn::GetLane(wy);
  const auto byte = [&](int i) { return static_cast<int>((q >> (8 * i)) & 255U); };
  const int left = byte(0) * (64 - y) + byte(2) * y, right = byte(1) * (64 - y) + byte(3) * y;
  return hn::Set(Ints(), (left * (64 - x) + right * x + 2048) >> 12);
}
inline hn::Vec<Ints> IndexOf(hn::Vec<Ints> x, hn::Vec<Ints> y, int stride) {
  return hn::Set(Ints(), hn::GetLane(y) * stride + hn::GetLane(x));
}
#else
using Shorts = hn::Repartition<std::int16_t, Ints>;

// Sums of products of neighbouring 16-bit lanes.
inline hn::Vec<Ints> Madd(hn::Vec<Shorts> a, hn::Vec<Shorts> b) {
  const Ints d;
  auto rest = hn::Zero(d);
  const auto sum = hn::ReorderWidenMulAccumulate(d, a, b, hn::Zero(d), rest);
  return hn::RearrangeToOddPlusEven(sum, rest);
}

// (64 - w, w) as 16-bit lanes.
inline hn::Vec<Shorts> WeightPair(hn::Vec<Ints> w) {
  const Ints d;
  return hn::BitCast(Shorts(), hn::Or(hn::Set(d, 64) - w, hn::ShiftLeft<16>(w)));
}

inline hn::Vec<Ints> Blend(hn::Vec<Ints> quads, hn::Vec<Ints> wx, hn::Vec<Ints> wy) {
  const Ints d;
  const auto bytes = hn::Set(d, 0x00FF00FF);
  const auto left = hn::And(quads, bytes);                      // (x, y), (x, y + 1)
  const auto right = hn::And(hn::ShiftRight<8>(quads), bytes);  // (x + 1, y), (x + 1, y + 1)
  const auto vertical = WeightPair(wy);
  const auto left_sum = Madd(hn::BitCast(Shorts(), left), vertical);
  const auto right_sum = Madd(hn::BitCast(Shorts(), right), vertical);
  const auto both = hn::BitCast(Shorts(), hn::Or(left_sum, hn::ShiftLeft<16>(right_sum)));
  return hn::ShiftRight<12>(Madd(both, WeightPair(wx)) + hn::Set(d, 2048));
}
inline hn::Vec<Ints> IndexOf(hn::Vec<Ints> x, hn::Vec<Ints> y, int stride) {
  const Ints d;
  return Madd(hn::BitCast(Shorts(), y), hn::BitCast(Shorts(), hn::Set(d, stride))) + x;
}
#endif

void Warp(const RowWarp& warp, int count, std::uint8_t* HWY_RESTRICT out) {
  const Floats f;
  const Ints d;
  const hn::Rebind<std::uint8_t, Ints> bytes;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const auto zero = hn::Zero(f), lowest = hn::Set(f, -32.0F);
  const auto ramp = hn::Iota(f, 0.0F);
  for (int i = 0; i < count; i += lanes) {
    const auto x = hn::Set(f, static_cast<float>(i)) + ramp;
    const auto numerator = [&](std::size_t k) {
      return hn::Set(f, warp.base[k]) + x * hn::Set(f, warp.step[k]);
    };
    const auto z = numerator(2);
    const auto reciprocal = hn::Set(f, 1.0F) / z;
    const auto u = numerator(0) * reciprocal - hn::Set(f, 32.0F);
    const auto v = numerator(1) * reciprocal - hn::Set(f, 32.0F);
    const auto in_front = z > hn::Set(f, kNearestDepth);
    const auto inside = hn::And(hn::And(u >= lowest, u <= hn::Set(f, warp.limit_x)),
                                hn::And(v >= lowest, v <= hn::Set(f, warp.limit_y)));
    const auto seen = hn::And(in_front, inside);
    // What is not seen may not be a number: it is replaced before it becomes an address.
    const auto clamped = [&](hn::Vec<Floats> value, float last) {
      const auto safe = hn::IfThenElseZero(seen, value);
      return hn::ConvertTo(d, hn::Min(hn::Max(safe, zero), hn::Set(f, last)) + hn::Set(f, 0.5F));
    };
    const auto u64 = clamped(u, warp.last_x), v64 = clamped(v, warp.last_y);
    const auto index = IndexOf(hn::ShiftRight<6>(u64), hn::ShiftRight<6>(v64), warp.stride);
    const auto quads = hn::GatherIndex(d, reinterpret_cast<const std::int32_t*>(warp.quads), index);
    const auto fraction = hn::Set(d, 63);
    const auto value =
        hn::Max(Blend(quads, hn::And(u64, fraction), hn::And(v64, fraction)), hn::Set(d, 1));
    const auto luma = hn::IfThenElseZero(hn::RebindMask(d, seen), value);
    hn::StoreU(hn::DemoteTo(bytes, luma), bytes, out + i);
  }
}

// Unsigned a > b, as 255 or 0.
inline hn::Vec<Bytes> Brighter(hn::Vec<Bytes> a, hn::Vec<Bytes> b) {
  return hn::VecFromMask(Bytes(), a > b);
}

template <class Visit>
inline void ForEachNeighbour(const Visit& visit) {
  std::size_t k = 0;
  for (int dy = -kCensus; dy <= kCensus; ++dy) {
    for (int dx = -kCensus; dx <= kCensus; ++dx) {
      if (dx != 0 || dy != 0) visit(k++, dx, dy);
    }
  }
}

void ReferenceCensus(const Warped& luma, int rows, int columns, CensusPlanes& planes) {
  const Bytes d;
  for (int r = 0; r < rows; ++r) {
    const auto at = [&](int dx, int dy) {
      const int in = r + kCensus + dy;
      return luma[static_cast<std::size_t>(in)].data() + kCensus + dx;
    };
    auto& row = planes[static_cast<std::size_t>(r)];
    for (int c = 0; c < columns; c += static_cast<int>(hn::Lanes(d))) {
      const auto centre = hn::LoadU(d, at(0, 0) + c);
      ForEachNeighbour([&](std::size_t k, int dx, int dy) {
        hn::StoreU(Brighter(hn::LoadU(d, at(dx, dy) + c), centre), d, row[k].data() + c);
      });
    }
  }
}

void CensusDistance(const Warped& warped, const CensusPlanes& planes, int rows, int columns,
                    std::array<Row, kCensusRows>& distance) {
  const Bytes d;
  const auto unseen = hn::Set(d, std::uint8_t{kUnseen});
  for (int r = 0; r < rows; ++r) {
    const auto at = [&](int dx, int dy) {
      const int in = r + kCensus + dy;
      return warped[static_cast<std::size_t>(in)].data() + kCensus + dx;
    };
    const auto& reference = planes[static_cast<std::size_t>(r)];
    for (int c = 0; c < columns; c += static_cast<int>(hn::Lanes(d))) {
      const auto centre = hn::LoadU(d, at(0, 0) + c);
      auto different = hn::Zero(d);
      ForEachNeighbour([&](std::size_t k, int dx, int dy) {
        const auto mine = Brighter(hn::LoadU(d, at(dx, dy) + c), centre);
        different = different - hn::Xor(mine, hn::LoadU(d, reference[k].data() + c));
      });
      const auto value = hn::IfThenElse(centre == hn::Zero(d), unseen, different);
      hn::StoreU(value, d, distance[static_cast<std::size_t>(r)].data() + c);
    }
  }
}

// Sum of the kHalf smallest of the sources' distances, by insertion into a sorted list.
template <std::size_t kHalf>
void SmallestSum(const Scratch& scratch, std::size_t sources, int rows, int columns,
                 std::array<Row, kCensusRows>& best) {
  const Bytes d;
  const auto most = hn::Set(d, std::uint8_t{255});
  for (std::size_t r = 0; r < static_cast<std::size_t>(rows); ++r) {
    for (int c = 0; c < columns; c += static_cast<int>(hn::Lanes(d))) {
      hn::Vec<Bytes> smallest[4] = {most, most, most, most};
      for (std::size_t s = 0; s < sources; ++s) {
        auto value = hn::LoadU(d, scratch.distance[s][r].data() + c);
        for (std::size_t k = 0; k < kHalf; ++k) {
          const auto lower = hn::Min(smallest[k], value);
          value = hn::Max(smallest[k], value);
          smallest[k] = lower;
        }
      }
      auto sum = smallest[0];
      for (std::size_t k = 1; k < kHalf; ++k) sum = sum + smallest[k];
      hn::StoreU(sum, d, best[r].data() + c);
    }
  }
}

void BetterHalf(const Scratch& scratch, std::size_t sources, int rows, int columns,
                std::array<Row, kCensusRows>& best) {
  static_assert(kMaxSweepSources == 8);
  constexpr decltype(&SmallestSum<1>) kOfHalf[] = {SmallestSum<1>, SmallestSum<2>, SmallestSum<3>,
                                                   SmallestSum<4>};
  kOfHalf[(sources - 1) / 2](scratch, sources, rows, columns, best);
}

// 3x3 box, scaled to 8 times the mean.
void BoxRow(const std::array<Row, kCensusRows>& best, int r, int width, int scale,
            std::uint16_t* HWY_RESTRICT sums, std::uint8_t* HWY_RESTRICT codes) {
  const Words d;
  const hn::Rebind<std::uint8_t, Words> bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto row = [&](int dy) {
    const int in = r + kBox + dy;
    return best[static_cast<std::size_t>(in)].data();
  };
  for (int c = 0; c < width + 2 * kBox; c += lanes) {
    const auto load = [&](int dy) { return hn::PromoteTo(d, hn::LoadU(bytes, row(dy) + c)); };
    hn::StoreU(load(-1) + load(0) + load(1), d, sums + c);
  }
  const auto factor = hn::Set(d, static_cast<std::uint16_t>(scale));
  const auto most = hn::Set(d, std::uint16_t{CostVolume::kMaxCost});
  for (int c = 0; c < width; c += lanes) {
    const auto sum =
        hn::LoadU(d, sums + c) + hn::LoadU(d, sums + c + 1) + hn::LoadU(d, sums + c + 2);
    const auto code = hn::Min(hn::MulHigh(hn::ShiftLeft<4>(sum), factor), most);
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(hn::RebindToSigned<Words>(), code)), bytes,
               codes + c);
  }
}

void LoadReference(const SweepImage& image, const Rect& tile, Warped& luma) {
  for (int r = 0; r < tile.height + 2 * kHalo; ++r) {
    const std::uint8_t* in =
        image.luma().row(std::clamp(tile.y + r - kHalo, 0, image.height() - 1));
    for (int c = 0; c < tile.width + 2 * kHalo; ++c) {
      luma[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] =
          in[std::clamp(tile.x + c - kHalo, 0, image.width() - 1)];
    }
  }
}

void CostOfTile(const SweepImage& reference, const std::vector<SweepSource>& sources,
                const InverseDepthLabels& labels, const Rect& tile, Scratch& scratch,
                CostVolume& volume) {
  const int columns = tile.width + 2 * kBox, rows = tile.height + 2 * kBox;
  const int half = (static_cast<int>(sources.size()) + 1) / 2;
  const int scale = (65536 * 8 + 72 * half) / (144 * half);  // of 16 * the box's sum, >> 16
  LoadReference(reference, tile, scratch.warped);
  ReferenceCensus(scratch.warped, rows, columns, scratch.census);
  for (int first = 0; first < labels.count(); first += kTileLabels) {
    const int count = std::min(kTileLabels, labels.count() - first);
    for (int i = 0; i < count; ++i) {
      const int label = first + i;
      const double w = labels.w[static_cast<std::size_t>(label)];
      for (std::size_t s = 0; s < sources.size(); ++s) {
        for (int r = 0; r < tile.height + 2 * kHalo; ++r) {
          const RowWarp warp = WarpOfRow(sources[s], w, tile.x - kHalo, tile.y + r - kHalo);
          Warp(warp, tile.width + 2 * kHalo, scratch.warped[static_cast<std::size_t>(r)].data());
        }
        CensusDistance(scratch.warped, scratch.census, rows, columns, scratch.distance[s]);
      }
      BetterHalf(scratch, sources.size(), rows, columns, scratch.best);
      for (int y = 0; y < tile.height; ++y) {
        std::uint8_t row[kTileColumns + kSlack];
        BoxRow(scratch.best, y, tile.width, scale, scratch.column_sums.data(), row);
        std::memcpy(scratch.codes.data() + (i * kTileRows + y) * kTileColumns, row,
                    static_cast<std::size_t>(tile.width));
      }
    }
    StoreLabels(scratch.codes.data(), kTileColumns, kTileRows * kTileColumns, tile, first, count,
                volume);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace plane_sweep
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace plane_sweep {
HWY_EXPORT(CostOfTile);
}  // namespace plane_sweep

SweepImage::SweepImage(Image<std::uint8_t> luma) : luma_(std::move(luma)), quads_(luma_.size()) {
  std::size_t i = 0;
  for (int y = 0; y < luma_.height(); ++y) {
    const std::uint8_t* row = luma_.row(y);
    const std::uint8_t* below = luma_.row(std::min(y + 1, luma_.height() - 1));
    for (int x = 0; x < luma_.width(); ++x, ++i) {
      const int right = std::min(x + 1, luma_.width() - 1);
      quads_[i] = static_cast<std::uint32_t>(row[x]) | static_cast<std::uint32_t>(row[right]) << 8 |
                  static_cast<std::uint32_t>(below[x]) << 16 |
                  static_cast<std::uint32_t>(below[right]) << 24;
    }
  }
}

double InverseDepthLabels::InverseDepth(SubLabel label) const {
  const auto last = w.size() - 1;
  const std::size_t below = std::min<std::size_t>(label / kSubLabels, last);
  const double share = static_cast<double>(label % kSubLabels) / kSubLabels;
  return below == last ? w[last] : w[below] + share * (w[below + 1] - w[below]);
}

CostVolume SweepCost(const SweepImage& reference, const std::vector<SweepSource>& sources,
                     const InverseDepthLabels& labels, VolumeBytes memory) {
  using namespace plane_sweep;  // NOLINT
  CostVolume volume(reference.width(), reference.height(), labels.count(), std::move(memory));
  const int across = (reference.width() + kTileColumns - 1) / kTileColumns;
  const int down = (reference.height() + kTileRows - 1) / kTileRows;
  ParallelForEach(0, static_cast<std::int64_t>(across) * down, [&](std::int64_t i) {
    const int x = static_cast<int>(i % across) * kTileColumns,
              y = static_cast<int>(i / across) * kTileRows;
    const Rect tile{x, y, std::min(kTileColumns, reference.width() - x),
                    std::min(kTileRows, reference.height() - y)};
    const auto scratch = std::make_unique<Scratch>();
    HWY_DYNAMIC_DISPATCH(CostOfTile)(reference, sources, labels, tile, *scratch, volume);
  });
  return volume;
}

}  // namespace lamella
#endif  // HWY_ONCE
