// The slow, obvious simulation of a display: on each axis the overlap of every pixel with every
// modulator element and every emitter as the eye sees them on z = 0, and for each of these pairs
// what both panels are at every time. Knows nothing of the ray map.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "distribute/encode_barrier.h"
#include "distribute/simulate_eye.h"

namespace lamella::reference {

// Whether `slot` opens a modulator element: one of an opening that lies on the panel whole.
inline bool IsOpen(const Barrier& b, int slot, int element, int count) {
  for (int first = b.period_px / b.slots * slot; first + b.aperture_px <= count;
       first += b.period_px) {
    if (element >= first && element < first + b.aperture_px) return true;
  }
  return false;
}

// A bundle of lines of sight of a pixel that meet the same modulator element and emitter.
struct SeenPair {
  int element = -1, emitter = -1;  // -1: beside the panel
  double weight = 0;               // share of the pixel's lines of sight
};

// What every pixel of one axis sees of a layer; coordinates run with the indices.
inline std::vector<std::vector<SeenPair>> SeenOnAxis(const Layer& layer, double pitch, int count,
                                                     double eye, double distance, double start,
                                                     double pixel, int pixels) {
  // Where the eye sees the left edge of element or emitter i of the plane z, on z = 0.
  const auto edge = [&](int i, double z) {
    return ((i - count / 2.0) * pitch * distance - eye * z) / (distance - z);
  };
  const double z = layer.position_mm, z_emitter = layer.position_mm - layer.d0_mm;
  std::vector<std::vector<SeenPair>> seen(static_cast<std::size_t>(pixels));
  for (int i = 0; i < pixels; ++i) {
    const double low = start + i * pixel, high = low + pixel;
    double beside = 1;
    for (int element = 0; element < count; ++element) {
      const double from = std::max(low, edge(element, z)),
                   to = std::min(high, edge(element + 1, z));
      if (to <= from) continue;
      for (int emitter = 0; emitter < count; ++emitter) {
        const double weight = (std::min(to, edge(emitter + 1, z_emitter)) -
                               std::max(from, edge(emitter, z_emitter))) /
                              pixel;
        if (weight <= 0) continue;
        beside -= weight;
        seen[static_cast<std::size_t>(i)].push_back({element, emitter, weight});
      }
    }
    seen[static_cast<std::size_t>(i)].push_back({-1, -1, std::max(0.0, beside)});
  }
  return seen;
}

// How far a barrier is open in a slot on one axis; beside the panel as far as it is in the mean.
inline double Openness(const Barrier& b, int slot, int element, int count) {
  if (element < 0) return static_cast<double>(b.aperture_px) / b.period_px;
  return IsOpen(b, slot, element, count) ? 1 : 0;
}

struct SlowPixel {
  double r = 0, g = 0, b = 0, known = 0, paths = 0;
};

// What a layer's two panels are at one time, on a line of sight: the slot that they are told to
// show and, of the share `slot_crosstalk`, the one before.
struct SlowLayer {
  const Display& display;
  const Barrier& barrier;
  const std::vector<EmitterImage>& slots;

  double Transmittance(int slot, const SeenPair& x, const SeenPair& y) const {
    const int k = barrier.slots;
    const double open = Openness(barrier, slot % k, x.element, display.emitter_columns()) *
                        Openness(barrier, slot / k, y.element, display.emitter_rows());
    return 1 / barrier.contrast + (1 - 1 / barrier.contrast) * open;
  }
  double Light(float content) const {
    return 1 / display.contrast + (1 - 1 / display.contrast) * static_cast<double>(content);
  }

  void AddAt(int slot, int before, const SeenPair& x, const SeenPair& y, double gain,
             SlowPixel& pixel) const {
    const double late = display.slot_crosstalk;
    const double weight =
        gain * x.weight * y.weight *
        ((1 - late) * Transmittance(slot, x, y) + late * Transmittance(before, x, y));
    pixel.paths += weight;
    if (x.emitter < 0 || y.emitter < 0) return;
    for (const auto& [shown, share] : {std::pair(slot, 1 - late), std::pair(before, late)}) {
      const EmitterImage& image = slots[static_cast<std::size_t>(shown)];
      const Rgb color = image.color(x.emitter, y.emitter);
      pixel.r += weight * share * Light(color.r);
      pixel.g += weight * share * Light(color.g);
      pixel.b += weight * share * Light(color.b);
      pixel.known += weight * share * static_cast<double>(image.coverage(x.emitter, y.emitter));
    }
  }
};

inline EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye) {
  std::vector<SlowPixel> pixels(static_cast<std::size_t>(eye.width) *
                                static_cast<std::size_t>(eye.height));
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Layer& layer = display.layers[l];
    const Barrier& b = BarrierOf(display, l);
    const double pitch = display.emitter_pitch_mm();
    const auto columns = SeenOnAxis(layer, pitch, display.emitter_columns(), eye.position.x(),
                                    eye.position.z(), eye.left_mm, eye.pixel_mm, eye.width);
    const auto rows = SeenOnAxis(layer, pitch, display.emitter_rows(), -eye.position.y(),
                                 eye.position.z(), -eye.top_mm, eye.pixel_mm, eye.height);
    const double open = static_cast<double>(b.slots) * b.aperture_px / b.period_px;
    const SlowLayer seen{display, b, layers.slots[l]};
    const std::vector<int> order = SlotOrder(b.slots);
    for (std::size_t t = 0; t < order.size(); ++t) {
      const int before = order[(t + order.size() - 1) % order.size()];
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        const auto width = static_cast<std::size_t>(eye.width);
        for (const SeenPair& y : rows[i / width]) {
          for (const SeenPair& x : columns[i % width]) {
            seen.AddAt(order[t], before, x, y, 1 / (open * open), pixels[i]);
          }
        }
      }
    }
  }
  EyePicture picture{Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height)};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const SlowPixel& pixel = pixels[i];
    picture.color.data()[i] = {static_cast<float>(pixel.r), static_cast<float>(pixel.g),
                               static_cast<float>(pixel.b)};
    picture.coverage.data()[i] =
        pixel.paths > 0 ? static_cast<float>(pixel.known / pixel.paths) : 0.0F;
  }
  return picture;
}

}  // namespace lamella::reference
