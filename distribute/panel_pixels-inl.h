// Between a layer's emitters and its panel's pixels: an emitter fills its bin, and rows run the
// other way where the layer is seen by reflection. For .cc files: instantiated where it is used.
#pragma once

#include <algorithm>

#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// pixel_of(x, y) of emitter column x and row y, of `rows` rows; the picture is as wide as the
// panel.
template <class Pixel, class PixelOf>
Image<Pixel> PanelFromEmitters(const Display& display, const Layer& layer, int rows,
                               PixelOf pixel_of) {
  const int binning = display.binning_px;
  Image<Pixel> panel(display.width_px, rows * binning);
  for (int y = 0; y < panel.height(); ++y) {
    Pixel* row = panel.row(y);
    if (y % binning != 0) {
      std::copy_n(panel.row(y - 1), display.width_px, row);
      continue;
    }
    for (int x = 0; x < display.width_px / binning; ++x) {
      std::fill_n(row + x * binning, binning, pixel_of(x, y / binning));
    }
    if (layer.mirror_x) std::reverse(row, row + display.width_px);
  }
  return panel;
}

// Its inverse: the first pixel of every emitter's bin; `panel` is whole rows of bins.
template <class Pixel>
Image<Pixel> EmittersFromPanel(const Display& display, const Layer& layer,
                               ImageSpan<const Pixel> panel) {
  const int binning = display.binning_px;
  Image<Pixel> emitters(display.emitter_columns(), panel.height / binning);
  for (int y = 0; y < emitters.height(); ++y) {
    for (int x = 0; x < emitters.width(); ++x) {
      const int column = x * binning;
      emitters(x, y) = panel(layer.mirror_x ? display.width_px - 1 - column : column, y * binning);
    }
  }
  return emitters;
}

}  // namespace lamella
