#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/refine.cc"
#include "depth/refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lightfield/parallel.h"

#ifndef LAMELLA_DEPTH_REFINE_SHARED
#define LAMELLA_DEPTH_REFINE_SHARED
namespace lamella {
namespace refine {

constexpr int kColumns = 256;  // pixels of a row whose weights are made at once
constexpr int kSlack = 64;     // values that whole vectors may run over
constexpr int kMaxWindow = (2 * kMaxMedianRadius + 1) * (2 * kMaxMedianRadius + 1);

// Labels and colours with a border of pixels that do not vote.
struct Padded {
  Padded(ImageSpan<const SubLabel> labels, ImageSpan<const Rgb8> guide, int border_px)
      : border(border_px), stride(labels.width + 2 * border_px + kSlack) {
    const auto size =
        static_cast<std::size_t>(stride) * static_cast<std::size_t>(labels.height + 2 * border);
    label.assign(size, kNoLabel);
    for (auto& plane : color) plane.assign(size, 0);
    for (int y = 0; y < labels.height; ++y) {
      for (int x = 0; x < labels.width; ++x) {
        const std::size_t i = Index(x, y);
        label[i] = labels(x, y);
        color[0][i] = guide(x, y).r;
        color[1][i] = guide(x, y).g;
        color[2][i] = guide(x, y).b;
      }
    }
  }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y + border) * static_cast<std::size_t>(stride) +
           static_cast<std::size_t>(x + border);
  }
  int border, stride;
  std::vector<SubLabel> label;
  std::array<std::vector<std::int16_t>, 3> color;
};

// Weights 0..255 by colour distance: 121 of them fit into 16 bits.
using WeightTable = std::array<std::uint16_t, 3 * 255 + 1>;

inline WeightTable MakeWeights() {
  WeightTable table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] =
        static_cast<std::uint16_t>(std::lround(255.0 * std::exp(static_cast<double>(i) / -30.0)));
  }
  return table;
}

struct Scratch {
  std::array<std::array<std::uint16_t, kColumns + kSlack>, kMaxWindow> weights;  // by neighbour
  std::array<std::uint16_t, kColumns + kSlack> distance;
};

}  // namespace refine
}  // namespace lamella
#endif  // LAMELLA_DEPTH_REFINE_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace refine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Words = hn::ScalableTag<std::uint16_t>;
using Signed = hn::RebindToSigned<Words>;

void Distances(const Padded& padded, std::size_t from, std::size_t to, int count,
               std::uint16_t* out) {
  const Signed d;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    auto sum = hn::Zero(d);
    for (const auto& plane : padded.color) {
      sum = sum +
            hn::Abs(hn::LoadU(d, plane.data() + from + i) - hn::LoadU(d, plane.data() + to + i));
    }
    hn::StoreU(hn::BitCast(Words(), sum), Words(), out + i);
  }
}

// The weights of all neighbours of `count` pixels, neighbour by neighbour.
void Weigh(const Padded& padded, const WeightTable& table, int radius, std::size_t centre,
           int count, Scratch& scratch) {
  std::size_t neighbour = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx, ++neighbour) {
      const std::size_t at = centre + static_cast<std::size_t>(dy * padded.stride + dx);
      Distances(padded, centre, at, count, scratch.distance.data());
      std::uint16_t* weights = scratch.weights[neighbour].data();
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        weights[i] =
            padded.label[at + i] == kNoLabel ? std::uint16_t{0} : table[scratch.distance[i]];
      }
    }
  }
}

// Of one vector of pixels, bit by bit from the top: the smallest v for which the labels <= v have
// at least half of the weight, i.e. the labels < v are too light and v has the bit.
void Search(const Padded& padded, int radius, std::size_t centre, const std::uint16_t* weights,
            SubLabel* out) {
  const Words d;
  constexpr std::size_t kNext = kColumns + kSlack;
  const int side = 2 * radius + 1;
  auto total = hn::Zero(d), median = hn::Zero(d);
  for (int k = 0; k < side * side; ++k)
    total = total + hn::LoadU(d, weights + static_cast<std::size_t>(k) * kNext);
  const auto half = hn::ShiftRight<1>(total + hn::Set(d, std::uint16_t{1}));
  for (int bit = 15; bit >= 0; --bit) {
    const auto value = hn::Or(median, hn::Set(d, static_cast<std::uint16_t>(1U << bit)));
    auto below = hn::Zero(d);
    const std::uint16_t* w = weights;
    for (int dy = -radius; dy <= radius; ++dy) {
      const SubLabel* label = padded.label.data() + centre + dy * padded.stride - radius;
      for (int dx = 0; dx < side; ++dx, w += kNext) {
        below = below + hn::IfThenElseZero(hn::LoadU(d, label + dx) < value, hn::LoadU(d, w));
      }
    }
    median = hn::IfThenElse(below < half, value, median);
  }
  hn::StoreU(median, d, out);
}

void MedianRow(const Padded& padded, const WeightTable& table, int radius, int width, int y,
               Scratch& scratch, SubLabel* out) {
  const int lanes = static_cast<int>(hn::Lanes(Words()));
  SubLabel medians[kSlack];
  for (int x0 = 0; x0 < width; x0 += kColumns) {
    const int count = std::min(kColumns, width - x0);
    const std::size_t row = padded.Index(x0, y);
    Weigh(padded, table, radius, row, count, scratch);
    for (int i = 0; i < count; i += lanes) {
      const std::size_t centre = row + static_cast<std::size_t>(i);
      Search(padded, radius, centre, scratch.weights[0].data() + i, medians);
      for (int k = 0; k < std::min(lanes, count - i); ++k) {
        const bool known = padded.label[centre + static_cast<std::size_t>(k)] != kNoLabel;
        out[x0 + i + k] = known ? medians[k] : kNoLabel;
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace refine
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace refine {
HWY_EXPORT(MedianRow);
}  // namespace refine

Image<SubLabel> WeightedMedian(ImageSpan<const SubLabel> labels, ImageSpan<const Rgb8> guide,
                               int radius) {
  using namespace refine;  // NOLINT
  static const WeightTable table = MakeWeights();
  Image<SubLabel> out(labels.width, labels.height);
  const int r = std::clamp(radius, 0, kMaxMedianRadius);
  const Padded padded(labels, guide, r);
  ParallelFor(0, labels.height, 8, [&](std::int64_t first, std::int64_t last) {
    const auto scratch = std::make_unique<Scratch>();
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      HWY_DYNAMIC_DISPATCH(MedianRow)(padded, table, r, labels.width, y, *scratch, out.row(y));
    }
  });
  return out;
}

}  // namespace lamella
#endif  // HWY_ONCE
