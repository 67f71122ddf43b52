// From planes of costs, one per label, to a cost volume, where a pixel's labels are neighbours.
// Compiled once per target (hwy/foreach_target.h).

// Include guard, one per target.
#if defined(LAMELLA_DEPTH_STORE_LABELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LAMELLA_DEPTH_STORE_LABELS_INL_H
#undef LAMELLA_DEPTH_STORE_LABELS_INL_H
#else
#define LAMELLA_DEPTH_STORE_LABELS_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "depth/cost_volume.h"
#include "lightfield/image.h"

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {

constexpr int kStoredLabels = 16;  // at once

#if HWY_TARGET != HWY_SCALAR
// 16 pixels of 16 labels: four rounds that interleave each row with the one 8 rows on (a perfect
// shuffle of the 256 bytes; four of them swap rows and columns).
inline void Transpose16(const std::uint8_t* in, std::ptrdiff_t plane, std::uint8_t* out,
                        std::ptrdiff_t pixel) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Full128<std::uint8_t> d;
  using Vec = hn::Vec<decltype(d)>;
  Vec rows[16], next[16];
  for (int i = 0; i < 16; ++i) rows[i] = hn::LoadU(d, in + i * plane);
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 8; ++i) {
      next[2 * i] = hn::InterleaveLower(d, rows[i], rows[i + 8]);
      next[2 * i + 1] = hn::InterleaveUpper(d, rows[i], rows[i + 8]);
    }
    for (int i = 0; i < 16; ++i) rows[i] = next[i];
  }
  for (int i = 0; i < 16; ++i) hn::StoreU(rows[i], d, out + i * pixel);
}
#endif

// Labels [first, first + count) of the pixels of `tile`: in `planes`, label i of tile pixel (x, y)
// is at [i * plane + y * stride + x]. With the last label, the volume's padding is filled.
inline void StoreLabels(const std::uint8_t* planes, std::ptrdiff_t stride, std::ptrdiff_t plane,
                        const Rect& tile, int first, int count, CostVolume& volume) {
  const bool last = first + count == volume.labels;
  for (int y = 0; y < tile.height; ++y) {
    const std::uint8_t* in = planes + y * stride;
    std::uint8_t* out = volume.At(tile.x, tile.y + y) + first;
    int x = 0;
#if HWY_TARGET != HWY_SCALAR
    if (count == kStoredLabels) {
      for (; x + 16 <= tile.width; x += 16) {
        Transpose16(in + x, plane, out + static_cast<std::ptrdiff_t>(x) * volume.stride,
                    volume.stride);
      }
    }
#endif
    for (; x < tile.width; ++x) {
      for (int i = 0; i < count; ++i)
        out[static_cast<std::ptrdiff_t>(x) * volume.stride + i] = in[i * plane + x];
    }
    for (x = 0; last && x < tile.width; ++x) {
      std::uint8_t* costs = volume.At(tile.x + x, tile.y + y);
      std::fill(costs + volume.labels, costs + volume.stride, std::uint8_t{CostVolume::kMaxCost});
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#endif  // include guard
