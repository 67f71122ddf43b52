// The slow, obvious simulation of a display: every line of sight of every pixel, every slot in
// turn, modulator transmission times emitter. Knows nothing of the ray map.
#pragma once

#include <cmath>

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

struct SlowPixel {
  double r = 0, g = 0, b = 0, known = 0, paths = 0;
};

// A line of sight through (x0, y0, 0) in one slot of one layer.
inline void AddLine(const LayerImages& layers, const Display& display, std::size_t l, int slot_x,
                    int slot_y, const Eye& eye, double x0, double y0, double weight,
                    SlowPixel& pixel) {
  const Layer& layer = display.layers[l];
  const double pitch = display.emitter_pitch_mm(), d = eye.position.z();
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  const auto at = [&](double from, double e, double z) { return from + (e - from) * z / d; };
  const double z_emitter = layer.position_mm - layer.d0_mm;
  const auto column_of = [&](double x) {
    return static_cast<int>(std::floor(x / pitch + columns / 2.0));
  };
  const auto row_of = [&](double y) {
    return static_cast<int>(std::floor(rows / 2.0 - y / pitch));
  };
  const int element_x = column_of(at(x0, eye.position.x(), layer.position_mm));
  const int element_y = row_of(at(y0, eye.position.y(), layer.position_mm));
  const int emitter_x = column_of(at(x0, eye.position.x(), z_emitter));
  const int emitter_y = row_of(at(y0, eye.position.y(), z_emitter));
  const bool off_x = element_x < 0 || element_x >= columns || emitter_x < 0 || emitter_x >= columns;
  const bool off_y = element_y < 0 || element_y >= rows || emitter_y < 0 || emitter_y >= rows;
  const Barrier& b = std::get<Barrier>(layer.optics);
  // A line that misses the panel would have met an opening in a/P of the slots.
  const double mean_open = static_cast<double>(b.aperture_px) / b.period_px;
  const bool open_x = IsOpen(b, slot_x, element_x, columns);
  const bool open_y = IsOpen(b, slot_y, element_y, rows);
  weight *= (off_x ? mean_open : open_x ? 1 : 0) * (off_y ? mean_open : open_y ? 1 : 0);
  pixel.paths += weight;
  if (off_x || off_y) return;
  const EmitterImage& image = layers.slots[l][static_cast<std::size_t>(b.slots * slot_y + slot_x)];
  const Rgb color = image.color(emitter_x, emitter_y);
  pixel.r += weight * static_cast<double>(color.r);
  pixel.g += weight * static_cast<double>(color.g);
  pixel.b += weight * static_cast<double>(color.b);
  pixel.known += weight * static_cast<double>(image.coverage(emitter_x, emitter_y));
}

inline EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye,
                              int lines) {
  EyePicture picture{Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height)};
  const double step = eye.pixel_mm / lines;
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      SlowPixel pixel;
      for (int line = 0; line < lines * lines; ++line) {
        const double x0 = eye.left_mm + (x * lines + line % lines + 0.5) * step;
        const double y0 = eye.top_mm - (y * lines + line / lines + 0.5) * step;
        for (std::size_t l = 0; l < display.layers.size(); ++l) {
          const Barrier& b = BarrierOf(display, l);
          const double mean_of_slots = 1.0 / (b.slots * b.slots);
          const double brightness = std::pow(static_cast<double>(b.aperture_px) / b.period_px, 2);
          for (int slot = 0; slot < b.slots * b.slots; ++slot) {
            AddLine(layers, display, l, slot % b.slots, slot / b.slots, eye, x0, y0,
                    mean_of_slots / brightness / (lines * lines), pixel);
          }
        }
      }
      picture.color(x, y) = {static_cast<float>(pixel.r), static_cast<float>(pixel.g),
                             static_cast<float>(pixel.b)};
      picture.coverage(x, y) =
          pixel.paths > 0 ? static_cast<float>(pixel.known / pixel.paths) : 0.0F;
    }
  }
  return picture;
}

}  // namespace lamella::reference
