// A plain encoder for tests: every emitter shows what its centre ray meets in a scene given as a
// function of the ray. No prefilter; knows nothing of the ray map or of the encoder under test.
#pragma once

#include <cmath>
#include <functional>
#include <limits>

#include "distribute/distribute.h"
#include "lightfield/display.h"

namespace lamella::reference {

// What a scene shows along the line (x + slope_x z, y + slope_y z): its colour and depth, mm.
struct SceneHit {
  Rgb color;
  double z = 0;
};
using SceneOfLine = std::function<SceneHit(double x, double y, double slope_x, double slope_y)>;

// The centre (mm, from the left or the top edge of the panel) of the opening that feeds emitter
// `index` of `count` in `slot`: the one whose window of P emitters, shifted towards the viewer's
// fan, lies nearest.
inline double OpeningOf(const Display& display, const Layer& layer, int slot, int index,
                        int count) {
  const double p = display.emitter_pitch_mm();
  const Barrier& b = std::get<Barrier>(layer.optics);
  double best = 0, nearest = std::numeric_limits<double>::infinity();
  for (int i = -2; i <= count / b.period_px + 2; ++i) {
    const double centre =
        (b.period_px * i + b.period_px / b.slots * slot + b.aperture_px / 2.0) * p;
    const double from_middle = centre - count * p / 2;
    const double shift =
        display.shear ? std::floor(from_middle * layer.d0_mm /
                                       ((display.viewing_distance_mm - layer.position_mm) * p) +
                                   0.5)
                      : 0;
    const double distance = std::abs((index + 0.5) * p - (centre + shift * p));
    if (distance < nearest) {
      nearest = distance;
      best = centre;
    }
  }
  return best;
}

// Nearest layer, hard borders; coverage 1 everywhere.
inline LayerImages EncodeCentreRays(const Display& display, const SceneOfLine& scene) {
  LayerImages images;
  const double p = display.emitter_pitch_mm();
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Layer& layer = display.layers[l];
    const int k = SlotsPerAxis(layer);
    std::vector<EmitterImage> slots;
    for (int slot = 0; slot < k * k; ++slot) {
      EmitterImage image{Image<Rgb>(columns, rows), Image<float>(columns, rows, 1.0F)};
      for (int r = 0; r < rows; ++r) {
        const double ym = rows * p / 2 - OpeningOf(display, layer, slot / k, r, rows);
        const double slope_y = (ym - (rows / 2.0 - r - 0.5) * p) / layer.d0_mm;
        for (int c = 0; c < columns; ++c) {
          const double xm = OpeningOf(display, layer, slot % k, c, columns) - columns * p / 2;
          const double slope_x = (xm - (c + 0.5 - columns / 2.0) * p) / layer.d0_mm;
          const SceneHit hit = scene(xm - slope_x * layer.position_mm,
                                     ym - slope_y * layer.position_mm, slope_x, slope_y);
          std::size_t nearest = 0;
          for (std::size_t m = 1; m < display.layers.size(); ++m) {
            if (std::abs(hit.z - display.layers[m].position_mm) <
                std::abs(hit.z - display.layers[nearest].position_mm)) {
              nearest = m;
            }
          }
          if (nearest == l) image.color(c, r) = hit.color;
        }
      }
      slots.push_back(std::move(image));
    }
    images.slots.push_back(std::move(slots));
  }
  return images;
}

}  // namespace lamella::reference
