// Work goes by strips of rows and, within one, by blocks of labels: all that a block needs stays in
// the cache. Mask planes hold the reference's census, so that a warped row is compared without
// packing bits: count -= (warped(q) > warped(p)) xor reference(q) > reference(p), 0 or -1 each.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/plane_sweep.cc"
#include "depth/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lightfield/parallel.h"

#ifndef LAMELLA_DEPTH_PLANE_SWEEP_SHARED
#define LAMELLA_DEPTH_PLANE_SWEEP_SHARED
namespace lamella {
namespace plane_sweep {

constexpr int kRadius = 2;        // of the census
constexpr int kComparisons = 24;  // of the 5x5 window with its centre
constexpr int kUnseenCost = 14;   // slightly worse than chance
constexpr int kStripRows = 24;    // rows of cost that a task makes
constexpr int kLabels = 16;       // a block: written to the volume at once
constexpr int kPad = 128;         // bytes that whole vectors may run over at a row's end
constexpr int kMaxSources = 8;
constexpr int kSubPixels = 64;  // of the bilinear weights

// Rows of bytes with a margin at either end.
struct Plane {
  Plane() = default;
  Plane(int width, int height, int margin_px)
      : margin(margin_px),
        stride(width + 2 * margin_px + kPad),
        bytes(static_cast<std::size_t>(stride) * static_cast<std::size_t>(height)) {}
  std::uint8_t* Row(int y) {
    return bytes.data() + static_cast<std::ptrdiff_t>(y) * stride + margin;
  }
  const std::uint8_t* Row(int y) const {
    return bytes.data() + static_cast<std::ptrdiff_t>(y) * stride + margin;
  }
  int margin = 0, stride = 0;
  std::vector<std::uint8_t> bytes;
};

// A source's pixels, padded so that four bytes can be read from any pixel on, and its camera.
struct Source {
  std::vector<std::uint8_t> pixels;
  int width = 0, height = 0, stride = 0;
  Eigen::Matrix3d rotation_part;  // K_s R K_r^-1
  Eigen::Vector3d baseline_part;  // K_s t
};

// Numerators of the homography along a row: (x, y, z) = start + step * column.
struct RowMap {
  std::array<float, 3> start, step;
};

inline RowMap MapRow(const Source& source, double w, int y) {
  const Eigen::Vector3d start =
      source.rotation_part * Eigen::Vector3d(0.5, y + 0.5, 1) + w * source.baseline_part;
  const Eigen::Vector3d step = source.rotation_part.col(0);
  RowMap map{};
  for (int i = 0; i < 3; ++i) {
    map.start[static_cast<std::size_t>(i)] = static_cast<float>(start[i]);
    map.step[static_cast<std::size_t>(i)] = static_cast<float>(step[i]);
  }
  return map;
}

// A strip of the reference and all buffers of a task.
struct Strip {
  int first = 0, rows = 0;  // of the volume
  int width = 0, height = 0;
};

struct Scratch {
  Scratch(int width, int sources)
      : warped(width, kStripRows + 2 + 2 * kRadius, kRadius),
        seen(width, kStripRows + 2, 0),
        sums(width, kStripRows + 2, 1) {
    for (int i = 0; i < kComparisons; ++i) masks.emplace_back(width, kStripRows + 2, 0);
    for (int i = 0; i < sources; ++i) costs.emplace_back(width, kStripRows + 2, 0);
    for (int i = 0; i < kLabels; ++i) block.emplace_back(width, kStripRows, 0);
  }
  Plane warped, seen, sums;
  std::vector<Plane> masks;  // the reference's census, 0 or 255
  std::vector<Plane> costs;  // of each source
  std::vector<Plane> block;  // of each label
};

}  // namespace plane_sweep
}  // namespace lamella
#endif  // LAMELLA_DEPTH_PLANE_SWEEP_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace plane_sweep {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F32 = hn::ScalableTag<float>;
using I32 = hn::RebindToSigned<F32>;
using U8 = hn::ScalableTag<std::uint8_t>;

// Bilinear samples of a source along a row, for columns [-kRadius, width + kRadius). A point is
// seen where its four pixels are inside; elsewhere the nearest inside are read and `seen` is 0.
void WarpRow(const Source& source, const RowMap& map, int width, std::uint8_t* HWY_RESTRICT out,
             std::uint8_t* HWY_RESTRICT seen) {
  const F32 f;
  const I32 i;
  const hn::Rebind<std::uint8_t, I32> u8;
  const auto half = hn::Set(f, 0.5F);
  const auto scale = hn::Set(f, static_cast<float>(kSubPixels));
  const auto max_x = hn::Set(f, static_cast<float>((source.width - 1) * kSubPixels - 1));
  const auto max_y = hn::Set(f, static_cast<float>((source.height - 1) * kSubPixels - 1));
  const auto zero = hn::Zero(f);
  const auto stride = hn::Set(i, source.stride);
  const auto low_byte = hn::Set(i, 255);
  const auto low_bits = hn::Set(i, kSubPixels - 1);
  const auto full = hn::Set(i, kSubPixels);
  const auto* base = reinterpret_cast<const std::int32_t*>(source.pixels.data());
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int x = -kRadius; x < width + kRadius; x += lanes) {
    const auto column = hn::Add(hn::Set(f, static_cast<float>(x)), hn::Iota(f, 0.0F));
    const auto nx = hn::Add(hn::Mul(column, hn::Set(f, map.step[0])), hn::Set(f, map.start[0]));
    const auto ny = hn::Add(hn::Mul(column, hn::Set(f, map.step[1])), hn::Set(f, map.start[1]));
    const auto nz = hn::Add(hn::Mul(column, hn::Set(f, map.step[2])), hn::Set(f, map.start[2]));
    const auto front = hn::Gt(nz, zero);
    const auto z = hn::IfThenElse(front, nz, hn::Set(f, 1.0F));
    const auto u = hn::Mul(hn::Sub(hn::Div(nx, z), half), scale);
    const auto v = hn::Mul(hn::Sub(hn::Div(ny, z), half), scale);
    const auto inside = hn::And(front, hn::And(hn::And(hn::Ge(u, zero), hn::Le(u, max_x)),
                                               hn::And(hn::Ge(v, zero), hn::Le(v, max_y))));
    const auto fu = hn::ConvertTo(i, hn::Min(hn::Max(u, zero), max_x));
    const auto fv = hn::ConvertTo(i, hn::Min(hn::Max(v, zero), max_y));
    const auto offset = hn::Add(hn::Mul(hn::ShiftRight<6>(fv), stride), hn::ShiftRight<6>(fu));
    const auto upper = hn::GatherOffset(i, base, offset);
    const auto lower = hn::GatherOffset(i, base, hn::Add(offset, stride));
    const auto wx = hn::And(fu, low_bits), wy = hn::And(fv, low_bits);
    const auto cx = hn::Sub(full, wx), cy = hn::Sub(full, wy);
    const auto top = hn::Add(hn::Mul(hn::And(upper, low_byte), cx),
                             hn::Mul(hn::And(hn::ShiftRight<8>(upper), low_byte), wx));
    const auto bottom = hn::Add(hn::Mul(hn::And(lower, low_byte), cx),
                                hn::Mul(hn::And(hn::ShiftRight<8>(lower), low_byte), wx));
    const auto value = hn::ShiftRight<12>(
        hn::Add(hn::Add(hn::Mul(top, cy), hn::Mul(bottom, wy)), hn::Set(i, 2048)));
    hn::StoreU(hn::DemoteTo(u8, value), u8, out + x);
    if (seen != nullptr && x + lanes > 0) {
      const auto flag = hn::And(hn::BitCast(i, hn::VecFromMask(f, inside)), low_byte);
      HWY_ALIGN std::uint8_t flags[HWY_MAX_BYTES];
      hn::StoreU(hn::DemoteTo(u8, flag), u8, flags);
      for (int k = std::max(0, -x); k < lanes; ++k) seen[x + k] = flags[k];
    }
  }
}

// masks[i](x) = 255 where the i-th neighbour of the window is brighter than the centre.
void MaskRow(const Plane& image, int y, int width, std::vector<Plane>& masks, int row) {
  const U8 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  std::size_t index = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      if (dx == 0 && dy == 0) continue;
      const std::uint8_t* centre = image.Row(y);
      const std::uint8_t* other = image.Row(y + dy) + dx;
      std::uint8_t* out = masks[index++].Row(row);
      for (int x = 0; x < width; x += lanes) {
        const auto brighter = hn::Gt(hn::LoadU(d, other + x), hn::LoadU(d, centre + x));
        hn::StoreU(hn::VecFromMask(d, brighter), d, out + x);
      }
    }
  }
}

// Hamming distance of the warped row's census and the reference's.
void CensusRow(const Plane& warped, int y, int width, const std::vector<Plane>& masks, int row,
               const std::uint8_t* HWY_RESTRICT seen, std::uint8_t* HWY_RESTRICT cost) {
  const U8 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  std::array<const std::uint8_t*, kComparisons> others{}, references{};
  std::size_t index = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      if (dx == 0 && dy == 0) continue;
      others[index] = warped.Row(y + dy) + dx;
      references[index] = masks[index].Row(row);
      ++index;
    }
  }
  const std::uint8_t* centre_row = warped.Row(y);
  const auto unseen = hn::Set(d, static_cast<std::uint8_t>(kUnseenCost));
  for (int x = 0; x < width; x += lanes) {
    const auto centre = hn::LoadU(d, centre_row + x);
    auto count = hn::Zero(d);
    for (std::size_t k = 0; k < kComparisons; ++k) {
      const auto brighter = hn::VecFromMask(d, hn::Gt(hn::LoadU(d, others[k] + x), centre));
      count = hn::Sub(count, hn::Xor(brighter, hn::LoadU(d, references[k] + x)));
    }
    const auto is_seen = hn::MaskFromVec(hn::LoadU(d, seen + x));
    hn::StoreU(hn::IfThenElse(is_seen, count, unseen), d, cost + x);
  }
}

// The sum of the `keep` smallest costs over the sources.
void BestHalfRow(const std::vector<Plane>& costs, int row, int width, int keep,
                 std::uint8_t* HWY_RESTRICT sums) {
  const U8 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int sources = static_cast<int>(costs.size());
  std::array<const std::uint8_t*, kMaxSources> rows{};
  for (int s = 0; s < sources; ++s)
    rows[static_cast<std::size_t>(s)] = costs[static_cast<std::size_t>(s)].Row(row);
  for (int x = 0; x < width; x += lanes) {
    hn::Vec<U8> c[kMaxSources];
    for (int s = 0; s < sources; ++s) c[s] = hn::LoadU(d, rows[static_cast<std::size_t>(s)] + x);
    auto sum = hn::Zero(d);
    for (int k = 0; k < keep; ++k) {  // bubbles the k-th smallest to place k
      for (int s = sources - 1; s > k; --s) {
        const auto smaller = hn::Min(c[s - 1], c[s]);
        c[s] = hn::Max(c[s - 1], c[s]);
        c[s - 1] = smaller;
      }
      sum = hn::Add(sum, c[k]);
    }
    hn::StoreU(sum, d, sums + x);
  }
}

// Mean of 3x3 sums of `keep` costs, scaled to 0..kMaxCost; `above` and `below` repeat at the
// border.
void BoxRow(const std::uint8_t* HWY_RESTRICT above, const std::uint8_t* HWY_RESTRICT here,
            const std::uint8_t* HWY_RESTRICT below, int width, int keep,
            std::uint8_t* HWY_RESTRICT out) {
  const hn::ScalableTag<std::uint16_t> d16;
  const hn::RebindToSigned<decltype(d16)> signed16;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const auto factor = hn::Set(d16, static_cast<std::uint16_t>(8 * 65536 / (9 * keep)));
  const auto most = hn::Set(d16, static_cast<std::uint16_t>(CostVolume::kMaxCost));
  const auto load = [&](const std::uint8_t* row, int x) {
    return hn::PromoteTo(d16, hn::LoadU(d8, row + x));
  };
  for (int x = 0; x < width; x += lanes) {
    auto sum = hn::Zero(d16);
    for (const std::uint8_t* row : {above, here, below}) {
      sum = hn::Add(sum, hn::Add(load(row, x - 1), hn::Add(load(row, x), load(row, x + 1))));
    }
    const auto mean = hn::Min(hn::MulHigh(sum, factor), most);
    hn::StoreU(hn::DemoteTo(d8, hn::BitCast(signed16, mean)), d8, out + x);
  }
}

void CostOfStrip(const Plane& padded, const std::vector<Source>& sources,
                 const InverseDepthRange& range, const Strip& strip, Scratch& scratch,
                 CostVolume& volume) {
  const int keep = (static_cast<int>(sources.size()) + 1) / 2;
  // Rows of cost that the box needs; at the picture's border the nearest row is repeated.
  const int first = std::max(0, strip.first - 1);
  const int last = std::min(strip.height, strip.first + strip.rows + 1);
  for (int y = first; y < last; ++y) {
    MaskRow(padded, y + kRadius, strip.width, scratch.masks, y - first);
  }
  for (int block = 0; block < range.labels; block += kLabels) {
    const int labels = std::min(kLabels, range.labels - block);
    for (int k = 0; k < labels; ++k) {
      const double w = range.At(block + k);
      for (std::size_t s = 0; s < sources.size(); ++s) {
        for (int y = first - kRadius; y < last + kRadius; ++y) {
          const bool inner = y >= first && y < last;
          WarpRow(sources[s], MapRow(sources[s], w, y), strip.width,
                  scratch.warped.Row(y - first + kRadius),
                  inner ? scratch.seen.Row(y - first) : nullptr);
        }
        for (int row = 0; row < last - first; ++row) {
          CensusRow(scratch.warped, row + kRadius, strip.width, scratch.masks, row,
                    scratch.seen.Row(row), scratch.costs[s].Row(row));
        }
      }
      for (int row = 0; row < last - first; ++row) {
        std::uint8_t* sums = scratch.sums.Row(row);
        BestHalfRow(scratch.costs, row, strip.width, keep, sums);
        sums[-1] = sums[0];
        sums[strip.width] = sums[strip.width - 1];
      }
      for (int y = strip.first; y < strip.first + strip.rows; ++y) {
        const auto sums = [&](int at) {
          return scratch.sums.Row(std::clamp(at, 0, strip.height - 1) - first);
        };
        BoxRow(sums(y - 1), sums(y), sums(y + 1), strip.width, keep,
               scratch.block[static_cast<std::size_t>(k)].Row(y - strip.first));
      }
    }
    for (int y = 0; y < strip.rows; ++y) {
      std::array<const std::uint8_t*, kLabels> rows{};
      for (int k = 0; k < labels; ++k)
        rows[static_cast<std::size_t>(k)] = scratch.block[static_cast<std::size_t>(k)].Row(y);
      for (int x = 0; x < strip.width; ++x) {
        std::uint8_t* out = volume.At(x, strip.first + y) + block;
        for (int k = 0; k < labels; ++k) out[k] = rows[static_cast<std::size_t>(k)][x];
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace plane_sweep
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace plane_sweep {
HWY_EXPORT(CostOfStrip);

namespace {

Eigen::Matrix3d Intrinsics(const Camera& camera) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return k;
}

Source Prepare(const SweepSource& from, const Camera& reference) {
  Source source;
  source.width = from.grey.width;
  source.height = from.grey.height;
  source.stride = from.grey.width + 4;
  source.pixels.resize(static_cast<std::size_t>(source.stride) *
                       static_cast<std::size_t>(source.height + 1));
  for (int y = 0; y < source.height; ++y) {
    std::copy_n(from.grey.row(y), source.width,
                source.pixels.begin() + static_cast<std::ptrdiff_t>(y) * source.stride);
  }
  const Eigen::Matrix3d k = Intrinsics(from.camera);
  source.rotation_part =
      k * from.source_from_reference.rotation.toRotationMatrix() * Intrinsics(reference).inverse();
  source.baseline_part = k * from.source_from_reference.translation;
  return source;
}

// The reference with its border repeated by the census' radius on all sides.
Plane Padded(ImageSpan<const std::uint8_t> image) {
  Plane plane(image.width, image.height + 2 * kRadius, kRadius);
  for (int y = -kRadius; y < image.height + kRadius; ++y) {
    const std::uint8_t* from = image.row(std::clamp(y, 0, image.height - 1));
    std::uint8_t* to = plane.Row(y + kRadius);
    for (int x = -kRadius; x < image.width + kRadius; ++x) {
      to[x] = from[std::clamp(x, 0, image.width - 1)];
    }
  }
  return plane;
}

}  // namespace
}  // namespace plane_sweep

CostVolume SweepPlanes(ImageSpan<const std::uint8_t> reference, const Camera& camera,
                       const std::vector<SweepSource>& sources, const InverseDepthRange& range) {
  using namespace plane_sweep;
  std::vector<Source> prepared;
  for (const SweepSource& source : sources) prepared.push_back(Prepare(source, camera));
  const Plane padded = Padded(reference);
  CostVolume volume(reference.width, reference.height, range.labels);
  const int strips = (reference.height + kStripRows - 1) / kStripRows;
  ParallelForEach(0, strips, [&](std::int64_t i) {
    Strip strip;
    strip.first = static_cast<int>(i) * kStripRows;
    strip.rows = std::min(kStripRows, reference.height - strip.first);
    strip.width = reference.width;
    strip.height = reference.height;
    Scratch scratch(strip.width, static_cast<int>(prepared.size()));
    HWY_DYNAMIC_DISPATCH(CostOfStrip)(padded, prepared, range, strip, scratch, volume);
    for (int y = strip.first; y < strip.first + strip.rows; ++y) {
      for (int x = 0; x < strip.width; ++x) {
        std::fill(volume.At(x, y) + range.labels, volume.At(x, y) + volume.stride,
                  static_cast<std::uint8_t>(CostVolume::kMaxCost));
      }
    }
  });
  return volume;
}

}  // namespace lamella
#endif  // HWY_ONCE
