#include "pipeline/overview.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "depth/resize_area.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/emitter_rows.h"
#include "pipeline/report/picture.h"

namespace lamella {
namespace {

constexpr int kHeight = 270, kGap = 6;  // px
constexpr int kWidest = 2;              // heights; of a wider picture the middle is shown

// `part` of a picture, of which `row_of` gives whole rows from the top on.
Image<Rgb> AsPane(const Rect& part, const RowOf& row_of) {
  const int shown =
      static_cast<int>(std::min<std::int64_t>(part.width, std::int64_t{kWidest} * part.height));
  const int left = part.x + (part.width - shown) / 2;
  const double width = static_cast<double>(shown) * kHeight / part.height;
  return ResizeAreaDownwards(
      shown, part.height, [&](int y, Rgb*) { return row_of(part.y + y, nullptr) + left; },
      std::max(1, static_cast<int>(std::lround(width))), kHeight);
}

Image<Rgb> AsPane(ImageSpan<const Rgb> picture) {
  return AsPane({0, 0, picture.width, picture.height}, [&](int y, Rgb*) { return picture.row(y); });
}

// The part of a panel that lies behind the eye's picture; all of it where that is none.
Rect BehindThePicture(const Display& display, const Eye& eye) {
  const double pitch = display.emitter_pitch_mm();
  const auto emitter = [&](double mm, double size_mm, int count) {
    return std::clamp(static_cast<int>(std::lround((mm + size_mm / 2) / pitch)), 0, count);
  };
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  const int left = emitter(eye.left_mm, display.width_mm(), columns);
  const int right = emitter(eye.left_mm + eye.width * eye.pixel_mm, display.width_mm(), columns);
  const int top = emitter(-eye.top_mm, display.height_mm(), rows);
  const int bottom = emitter(eye.height * eye.pixel_mm - eye.top_mm, display.height_mm(), rows);
  if (right <= left || bottom <= top) return {0, 0, columns, rows};
  return {left, top, right - left, bottom - top};
}

Image<Rgb8> SideBySide(const std::vector<Image<Rgb>>& panes) {
  int width = -kGap;
  for (const Image<Rgb>& pane : panes) width += pane.width() + kGap;
  Image<Rgb8> all(width, kHeight, {255, 255, 255});
  int left = 0;
  for (const Image<Rgb>& pane : panes) {
    const Image<Rgb8> codes = EncodeSrgb8(pane.span());
    for (int y = 0; y < kHeight; ++y) {
      std::copy_n(codes.row(y), codes.width(), all.row(y) + left);
    }
    left += pane.width() + kGap;
  }
  return all;
}

}  // namespace

Image<Rgb8> Overview(ImageSpan<const Rgb> photograph, const DepthMap& depth,
                     const OpenEmitters& emitters, const Display& display, const Eye& eye,
                     ImageSpan<const Rgb8> seen) {
  std::vector<Image<Rgb>> panes;
  panes.push_back(AsPane(photograph));
  const Image<Rgb8> colored = ColoredDepth(depth, ScaleOf({&depth}), depth.depth.width());
  panes.push_back(AsPane(DecodeSrgb8(colored.span()).span()));
  const Rect part = BehindThePicture(display, eye);
  // Of many layers some, evenly spread.
  constexpr std::size_t kMostLayers = 4;
  const std::size_t n = display.layers.size(), shown = std::min(n, kMostLayers);
  std::vector<Image<Rgb>> of_layers(shown);
  ParallelForEach(0, std::ssize(of_layers), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    const std::size_t layer = shown == 1 ? 0 : at * (n - 1) / (shown - 1);
    of_layers[at] = AsPane(part, MeanRows(emitters, display, static_cast<int>(layer)));
  });
  std::move(of_layers.begin(), of_layers.end(), std::back_inserter(panes));
  panes.push_back(AsPane(DecodeSrgb8(seen).span()));
  return SideBySide(panes);
}

}  // namespace lamella
