#include "lightfield/weave_quilt.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lightfield/color.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Two neighbouring pixels along an axis of a tile.
struct Between {
  int first = 0, second = 0;
  float share = 0;  // of the second
  bool inside = false;
};

// Where panel pixels lie in a tile, along one axis. `stretch` of 1 fills the panel, more leaves
// bars.
std::vector<Between> Positions(int panel_px, int tile_px, double stretch, bool flip) {
  std::vector<Between> positions(static_cast<std::size_t>(panel_px));
  for (int i = 0; i < panel_px; ++i) {
    const double along = ((flip ? panel_px - 1 - i : i) + 0.5) / panel_px;
    const double place = stretch * (along - 0.5) + 0.5;
    Between& between = positions[static_cast<std::size_t>(i)];
    between.inside = place >= 0 && place <= 1;
    const double px = std::clamp(place * tile_px - 0.5, 0.0, tile_px - 1.0);
    between.first = static_cast<int>(px);
    between.second = std::min(between.first + 1, tile_px - 1);
    between.share = static_cast<float>(px - between.first);
  }
  return positions;
}

std::uint8_t Code(const Rgb8& pixel, int channel) {
  return channel == 0 ? pixel.r : channel == 1 ? pixel.g : pixel.b;
}

float Mix(float a, float b, float share) { return a + share * (b - a); }

float Sample(const ImageSpan<const Rgb8>& tile, const Between& x, const Between& y, int channel) {
  const auto light = [&](int column, int row) {
    return Srgb8ToLinear(Code(tile(column, row), channel));
  };
  return Mix(Mix(light(x.first, y.first), light(x.second, y.first), x.share),
             Mix(light(x.first, y.second), light(x.second, y.second), x.share), y.share);
}

// How far the picture must be stretched along x and along y for its aspect to be kept.
std::array<double, 2> StretchOf(const QuiltLayout& layout, const LookingGlass& c) {
  constexpr double kAlike = 0.01;  // names round the aspect
  const double panel = static_cast<double>(c.width_px) / c.height_px;
  const double ratio = layout.aspect.value_or(panel) / panel;
  if (std::abs(ratio - 1) < kAlike) return {1, 1};
  return {std::max(1.0, 1 / ratio), std::max(1.0, ratio)};
}

}  // namespace

ViewTaps TapsOf(double view, int views, ViewFilter filter) {
  const int nearest = ViewIndex(view, views), last = views - 1;
  if (filter == ViewFilter::kNearest) return {1, {nearest}, {1}};
  if (filter == ViewFilter::kLinear) {
    const auto next = static_cast<float>(std::clamp(view * views - nearest, 0.0, 1.0));
    return {2, {nearest, std::min(nearest + 1, last)}, {1 - next, next}};
  }
  const int reach = filter == ViewFilter::kGaussian ? 1 : 2;
  const double sigma = filter == ViewFilter::kGaussian ? 0.5 : 1;
  ViewTaps taps;
  float sum = 0;
  for (int i = nearest - reach; i <= nearest + reach; ++i) {
    const double away = (i + 0.5 - view * views) / sigma;
    const auto at = static_cast<std::size_t>(taps.count++);
    taps.views[at] = std::clamp(i, 0, last);
    taps.weights[at] = static_cast<float>(std::exp(-away * away / 2));
    sum += taps.weights[at];
  }
  for (float& weight : taps.weights) weight /= sum;
  return taps;
}

Image<Rgb8> WeaveQuilt(ImageSpan<const Rgb8> quilt, const QuiltLayout& layout, int views,
                       const LookingGlass& c, ViewFilter filter) {
  std::vector<ImageSpan<const Rgb8>> tiles;
  for (int view = 0; view < views; ++view) tiles.push_back(QuiltView(quilt, layout, view));
  const auto [stretch_x, stretch_y] = StretchOf(layout, c);
  const std::vector<Between> across =
      Positions(c.width_px, tiles.front().width, stretch_x, c.flip_x);
  const std::vector<Between> down =
      Positions(c.height_px, tiles.front().height, stretch_y, c.flip_y);
  const LookingGlassWeave weave = WeaveOf(c);
  Image<Rgb8> panel(c.width_px, c.height_px);
  const auto shown = [&](int column, int row, int channel) -> std::uint8_t {
    const Between& x = across[static_cast<std::size_t>(column)];
    const Between& y = down[static_cast<std::size_t>(row)];
    if (!x.inside || !y.inside) return 0;
    const ViewTaps taps = TapsOf(LookingGlassView(c, weave, column, row, channel), views, filter);
    float light = 0;
    for (std::size_t t = 0; t < static_cast<std::size_t>(taps.count); ++t) {
      const auto view = static_cast<std::size_t>(taps.views[t]);
      light += taps.weights[t] * Sample(tiles[view], x, y, channel);
    }
    return LinearToSrgb8(light);
  };
  ParallelForEach(0, c.height_px, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < c.width_px; ++x)
      panel(x, y) = {shown(x, y, 0), shown(x, y, 1), shown(x, y, 2)};
  });
  return panel;
}

}  // namespace lamella
