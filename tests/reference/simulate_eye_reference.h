// The slow, obvious simulation of a display: on each axis the overlap of every pixel with every
// modulator element and every emitter as the eye sees them on z = 0; every slot in turn. Knows
// nothing of the ray map.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

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

struct SeenEmitter {
  int slot = 0, emitter = -1;  // -1: beside the panel, in any slot
  double weight = 0;           // share of the pixel's lines of sight
};

// What every pixel of one axis sees of a layer; coordinates run with the indices.
inline std::vector<std::vector<SeenEmitter>> SeenOnAxis(const Layer& layer, double pitch, int count,
                                                        double eye, double distance, double start,
                                                        double pixel, int pixels) {
  const Barrier& b = std::get<Barrier>(layer.optics);
  // Where the eye sees the left edge of element or emitter i of the plane z, on z = 0.
  const auto edge = [&](int i, double z) {
    return ((i - count / 2.0) * pitch * distance - eye * z) / (distance - z);
  };
  const double z = layer.position_mm, z_emitter = layer.position_mm - layer.d0_mm;
  std::vector<std::vector<SeenEmitter>> seen(static_cast<std::size_t>(pixels));
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
        for (int slot = 0; slot < b.slots; ++slot) {
          if (IsOpen(b, slot, element, count)) {
            seen[static_cast<std::size_t>(i)].push_back({slot, emitter, weight});
          }
        }
      }
    }
    // A line that misses the panel would have met an opening in a/P of the slots.
    const double openings = static_cast<double>(b.slots) * b.aperture_px / b.period_px;
    seen[static_cast<std::size_t>(i)].push_back({0, -1, std::max(0.0, beside) * openings});
  }
  return seen;
}

struct SlowPixel {
  double r = 0, g = 0, b = 0, known = 0, paths = 0;
};

inline void AddPixel(const std::vector<EmitterImage>& slots, int slots_per_axis,
                     const std::vector<SeenEmitter>& columns, const std::vector<SeenEmitter>& rows,
                     double gain, SlowPixel& pixel) {
  for (const SeenEmitter& row : rows) {
    for (const SeenEmitter& column : columns) {
      const double weight = gain * row.weight * column.weight;
      pixel.paths += weight;
      if (row.emitter < 0 || column.emitter < 0) continue;
      const EmitterImage& image =
          slots[static_cast<std::size_t>(slots_per_axis * row.slot + column.slot)];
      const Rgb color = image.color(column.emitter, row.emitter);
      pixel.r += weight * static_cast<double>(color.r);
      pixel.g += weight * static_cast<double>(color.g);
      pixel.b += weight * static_cast<double>(color.b);
      pixel.known += weight * static_cast<double>(image.coverage(column.emitter, row.emitter));
    }
  }
}

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
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto width = static_cast<std::size_t>(eye.width);
      AddPixel(layers.slots[l], b.slots, columns[i % width], rows[i / width], 1 / (open * open),
               pixels[i]);
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
