// Two passes over the volume, 2 bytes per label: pass 1 goes up and keeps the path from the bottom,
// pass 2 goes down in strips of rows, where the two horizontal paths are per row and the path from
// the top is per block of columns, and finishes each pixel at once.
//
// All path costs are 8-bit integers, so every target gives the same bytes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/sgm.cc"
#include "depth/sgm.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lightfield/parallel.h"

#ifndef LAMELLA_DEPTH_SGM_SHARED
#define LAMELLA_DEPTH_SGM_SHARED
namespace lamella {
namespace sgm {

constexpr int kBlock = CostVolume::kLabelBlock;
constexpr int kColumns = 32;  // of a block of columns
constexpr int kRows = 32;     // of a strip

// Penalty of a jump along the path from one guide value to the next.
struct JumpPenalty {
  explicit JumpPenalty(const SgmPenalties& penalties) {
    for (int step = 0; step < 256; ++step) {
      const int p2 = penalties.p2_contrast > 0
                         ? penalties.p2 * penalties.p2_contrast / (penalties.p2_contrast + step)
                         : penalties.p2;
      of[static_cast<std::size_t>(step)] = static_cast<std::uint8_t>(
          std::clamp(std::max(p2, penalties.p1 + 2), 0, SgmPenalties::kMaxPenalty));
    }
  }
  std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const {
    return of[static_cast<std::size_t>(std::abs(a - b))];
  }
  std::array<std::uint8_t, 256> of{};
};

// min(L - min L, P2) of the pixel before on a path, by label, between two borders that never win.
class PathState {
 public:
  PathState(int pixels, int stride)
      : stride_(stride + 2 * kBlock),
        values_(static_cast<std::size_t>(pixels) * static_cast<std::size_t>(stride_),
                static_cast<std::uint8_t>(SgmPenalties::kMaxPenalty)) {}
  std::uint8_t* At(int pixel) {
    return values_.data() + static_cast<std::ptrdiff_t>(pixel) * stride_ + kBlock;
  }

 private:
  int stride_;
  std::vector<std::uint8_t> values_;
};

struct Strip {  // path costs of a strip's rows from the left and from the right
  Strip(int width, int stride)
      : row_bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(stride)),
        left(row_bytes * kRows),
        right(row_bytes * kRows) {}
  std::size_t row_bytes;
  std::vector<std::uint8_t, PixelAllocator<std::uint8_t>> left, right;
};

}  // namespace sgm
}  // namespace lamella
#endif  // LAMELLA_DEPTH_SGM_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace sgm {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::CappedTag<std::uint8_t, kBlock>;
using Words = hn::CappedTag<std::uint16_t, kBlock / 2>;

template <class D>
inline hn::TFromD<D> SmallestLane(D d, hn::Vec<D> v) {
  hn::TFromD<D> lanes[kBlock];
  hn::StoreU(v, d, lanes);
  return *std::min_element(lanes, lanes + hn::Lanes(d));
}

// One step of a path: L of this pixel from its costs and the state before; its minimum.
inline std::uint8_t Step(const std::uint8_t* HWY_RESTRICT cost,
                         const std::uint8_t* HWY_RESTRICT before, int stride, int p1,
                         std::uint8_t* HWY_RESTRICT path) {
  const Bytes d;
  const auto penalty = hn::Set(d, p1);
  auto lowest = hn::Set(d, std::uint8_t{255});
  for (int i = 0; i < stride; i += static_cast<int>(hn::Lanes(d))) {
    const auto side = hn::Min(hn::LoadU(d, before + i - 1), hn::LoadU(d, before + i + 1));
    const auto step = hn::Min(hn::LoadU(d, before + i), side + penalty);
    const auto value = hn::LoadU(d, cost + i) + step;
    hn::StoreU(value, d, path + i);
    lowest = hn::Min(lowest, value);
  }
  return SmallestLane(d, lowest);
}

// The state that the next pixel of the path sees: a jump to it costs p2.
inline void Normalise(const std::uint8_t* HWY_RESTRICT path, int stride, std::uint8_t minimum,
                      std::uint8_t p2, std::uint8_t* HWY_RESTRICT state) {
  const Bytes d;
  const auto low = hn::Set(d, minimum), jump = hn::Set(d, p2);
  for (int i = 0; i < stride; i += static_cast<int>(hn::Lanes(d))) {
    hn::StoreU(hn::Min(hn::LoadU(d, path + i) - low, jump), d, state + i);
  }
}

// The first pixel of a path has nothing before it: L = C.
inline void Begin(std::uint8_t* state, int stride) {
  std::memset(state, 0, static_cast<std::size_t>(stride));
}

void UpwardPaths(const CostVolume& cost, ImageSpan<const std::uint8_t> guide, int p1,
                 const JumpPenalty& jump, int column_begin, int column_end, std::uint8_t* up) {
  const int stride = cost.stride;
  PathState state(column_end - column_begin, stride);
  for (int x = column_begin; x < column_end; ++x) Begin(state.At(x - column_begin), stride);
  for (int y = cost.height - 1; y >= 0; --y) {
    for (int x = column_begin; x < column_end; ++x) {
      const std::uint8_t* c = cost.At(x, y);
      std::uint8_t* path = up + (c - cost.costs.get());
      std::uint8_t* s = state.At(x - column_begin);
      const std::uint8_t minimum = Step(c, s, stride, p1, path);
      if (y > 0) Normalise(path, stride, minimum, jump(guide(x, y), guide(x, y - 1)), s);
    }
  }
}

// Both directions at once: two chains of dependent steps overlap in the processor.
void HorizontalPaths(const CostVolume& cost, const std::uint8_t* guide, int p1,
                     const JumpPenalty& jump, int y, std::uint8_t* left, std::uint8_t* right) {
  const int stride = cost.stride, width = cost.width;
  PathState state(2, stride);
  std::uint8_t* from_left = state.At(0);
  std::uint8_t* from_right = state.At(1);
  Begin(from_left, stride);
  Begin(from_right, stride);
  for (int i = 0; i < width; ++i) {
    const int j = width - 1 - i;
    std::uint8_t* path_left = left + static_cast<std::ptrdiff_t>(i) * stride;
    std::uint8_t* path_right = right + static_cast<std::ptrdiff_t>(j) * stride;
    const std::uint8_t low_left = Step(cost.At(i, y), from_left, stride, p1, path_left);
    const std::uint8_t low_right = Step(cost.At(j, y), from_right, stride, p1, path_right);
    if (i + 1 == width) break;
    Normalise(path_left, stride, low_left, jump(guide[i], guide[i + 1]), from_left);
    Normalise(path_right, stride, low_right, jump(guide[j], guide[j - 1]), from_right);
  }
}

// Smallest of the padded sums; the padding holds the largest value.
inline std::uint16_t Lowest(const std::uint16_t* sums, int stride) {
  const Words d;
  auto lowest = hn::Set(d, std::uint16_t{65535});
  for (int i = 0; i < stride; i += static_cast<int>(hn::Lanes(d))) {
    lowest = hn::Min(lowest, hn::LoadU(d, sums + i));
  }
  return SmallestLane(d, lowest);
}

inline int FirstEqual(const std::uint16_t* sums, std::uint16_t value) {
  const Words d;
  const auto wanted = hn::Set(d, value);
  for (int i = 0;; i += static_cast<int>(hn::Lanes(d))) {
    const auto lane = hn::FindFirstTrue(d, hn::Eq(hn::LoadU(d, sums + i), wanted));
    if (lane >= 0) return i + static_cast<int>(lane);
  }
}

inline void Sum(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* c,
                const std::uint8_t* e, int stride, std::uint16_t* HWY_RESTRICT sums) {
  const Words d;
  const hn::Rebind<std::uint8_t, Words> bytes;
  for (int i = 0; i < stride; i += static_cast<int>(hn::Lanes(d))) {
    const auto ab =
        hn::PromoteTo(d, hn::LoadU(bytes, a + i)) + hn::PromoteTo(d, hn::LoadU(bytes, b + i));
    const auto ce =
        hn::PromoteTo(d, hn::LoadU(bytes, c + i)) + hn::PromoteTo(d, hn::LoadU(bytes, e + i));
    hn::StoreU(ab + ce, d, sums + i);
  }
}

// Winner, its parabola and its uniqueness. `sums` has room for two labels on either side.
inline void Pick(std::uint16_t* sums, int labels, int stride, SubLabel* label,
                 std::uint8_t* uniqueness) {
  for (int d = labels; d < stride; ++d) sums[d] = 65535;
  const int lowest = Lowest(sums, stride);
  const int winner = FirstEqual(sums, static_cast<std::uint16_t>(lowest));
  *label = static_cast<SubLabel>(winner * kSubLabels);
  *uniqueness = 0;
  if (winner == 0 || winner == labels - 1) return;
  const int before = sums[winner - 1], after = sums[winner + 1];
  const int curvature = before + after - 2 * lowest;  // >= 1: the first minimum wins
  const int doubled = kSubLabels * (before - after);
  const int share = (doubled >= 0 ? doubled + curvature : doubled - curvature) / (2 * curvature);
  *label = static_cast<SubLabel>(*label + std::clamp(share, -kSubLabels / 2, kSubLabels / 2));
  for (int d = winner - 2; d <= winner + 2; ++d) sums[d] = 65535;
  const int second = Lowest(sums, stride);
  if (second == 65535) return;  // too few labels for a rival
  *uniqueness = static_cast<std::uint8_t>(std::min(255, 255 * (second - lowest) / (lowest + 4)));
}

// The path from the top through a strip, the sum of all four, the winner.
void FinishColumns(const CostVolume& cost, ImageSpan<const std::uint8_t> guide, int p1,
                   const JumpPenalty& jump, const Rect& block, const std::uint8_t* up,
                   const Strip& strip, PathState& state, LabelMap& map) {
  const int stride = cost.stride;
  std::vector<std::uint8_t> down(static_cast<std::size_t>(stride));
  std::vector<std::uint16_t> padded(static_cast<std::size_t>(stride + 4), 65535);
  std::uint16_t* sums = padded.data() + 2;
  for (int y = block.y; y < block.y + block.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y - block.y) * strip.row_bytes;
    for (int x = block.x; x < block.x + block.width; ++x) {
      const std::uint8_t* c = cost.At(x, y);
      const std::size_t at = row + static_cast<std::size_t>(x) * static_cast<std::size_t>(stride);
      std::uint8_t* s = state.At(x);
      const std::uint8_t minimum = Step(c, s, stride, p1, down.data());
      if (y + 1 < cost.height) {
        Normalise(down.data(), stride, minimum, jump(guide(x, y), guide(x, y + 1)), s);
      }
      Sum(strip.left.data() + at, strip.right.data() + at, up + (c - cost.costs.get()), down.data(),
          stride, sums);
      Pick(sums, cost.labels, stride, &map.label(x, y), &map.uniqueness(x, y));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sgm
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace sgm {
HWY_EXPORT(UpwardPaths);
HWY_EXPORT(HorizontalPaths);
HWY_EXPORT(FinishColumns);
}  // namespace sgm

LabelMap SemiGlobalMatch(const CostVolume& cost, ImageSpan<const std::uint8_t> guide,
                         const SgmPenalties& penalties, VolumeBytes& paths) {
  using namespace sgm;  // NOLINT
  const int width = cost.width, height = cost.height, stride = cost.stride, p1 = penalties.p1;
  LabelMap map{Image<SubLabel>(width, height), Image<std::uint8_t>(width, height)};
  const JumpPenalty jump(penalties);
  paths = AtLeast(cost.Bytes(), std::move(paths));
  std::uint8_t* up = paths.get();
  ParallelFor(0, width, kColumns, [&](std::int64_t first, std::int64_t last) {
    HWY_DYNAMIC_DISPATCH(UpwardPaths)
    (cost, guide, p1, jump, static_cast<int>(first), static_cast<int>(last), up);
  });
  Strip strip(width, stride);
  PathState down(width, stride);
  for (int x = 0; x < width; ++x) std::memset(down.At(x), 0, static_cast<std::size_t>(stride));
  for (int y = 0; y < height; y += kRows) {
    const int rows = std::min(kRows, height - y);
    ParallelForEach(0, rows, [&](std::int64_t r) {
      const int row = y + static_cast<int>(r);
      const std::size_t at = static_cast<std::size_t>(r) * strip.row_bytes;
      HWY_DYNAMIC_DISPATCH(HorizontalPaths)
      (cost, guide.row(row), p1, jump, row, strip.left.data() + at, strip.right.data() + at);
    });
    ParallelFor(0, width, kColumns, [&](std::int64_t first, std::int64_t last) {
      const Rect block{static_cast<int>(first), y, static_cast<int>(last - first), rows};
      HWY_DYNAMIC_DISPATCH(FinishColumns)
      (cost, guide, p1, jump, block, up, strip, down, map);
    });
  }
  return map;
}

}  // namespace lamella
#endif  // HWY_ONCE
