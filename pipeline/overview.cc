#include "pipeline/overview.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "depth/resize_area.h"
#include "lightfield/image_io.h"
#include "pipeline/report/picture.h"

namespace lamella {
namespace {

constexpr int kHeight = 270, kGap = 6;  // px
constexpr int kWidest = 2;              // heights; of a wider picture the middle is shown

Image<Rgb> AsPane(ImageSpan<const Rgb> picture) {
  const int shown = static_cast<int>(
      std::min<std::int64_t>(picture.width, std::int64_t{kWidest} * picture.height));
  const ImageSpan<const Rgb> middle =
      picture.Sub({(picture.width - shown) / 2, 0, shown, picture.height});
  const double width = static_cast<double>(shown) * kHeight / picture.height;
  return ResizeArea(middle, std::max(1, static_cast<int>(std::lround(width))), kHeight);
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

Image<Rgb> MeanOfSlots(const std::vector<EmitterImage>& slots) {
  Image<Rgb> mean(slots[0].color.width(), slots[0].color.height());
  const float weight = 1.0F / static_cast<float>(slots.size());
  for (const EmitterImage& slot : slots) {
    for (std::size_t i = 0; i < mean.size(); ++i) mean.data()[i] += weight * slot.color.data()[i];
  }
  return mean;
}

Image<Rgb8> Overview(ImageSpan<const Rgb> photograph, const DepthMap& depth,
                     const LayerImages& layers, const Display& display, const Eye& eye,
                     ImageSpan<const Rgb8> seen) {
  std::vector<Image<Rgb>> panes;
  panes.push_back(AsPane(photograph));
  const Image<Rgb8> colored = ColoredDepth(depth, ScaleOf({&depth}), depth.depth.width());
  panes.push_back(AsPane(DecodeSrgb8(colored.span()).span()));
  const Rect part = BehindThePicture(display, eye);
  // Of many layers some, evenly spread.
  constexpr std::size_t kMostLayers = 4;
  const std::size_t n = layers.slots.size(), shown = std::min(n, kMostLayers);
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t layer = shown == 1 ? 0 : i * (n - 1) / (shown - 1);
    panes.push_back(AsPane(MeanOfSlots(layers.slots[layer]).span().Sub(part)));
  }
  panes.push_back(AsPane(DecodeSrgb8(seen).span()));
  return SideBySide(panes);
}

}  // namespace lamella
