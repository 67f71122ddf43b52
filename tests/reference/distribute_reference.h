// Distribution as ranieri2012.md section 4 states it: many rays in every emitter's beam, each asked
// on its own, weighted and averaged. Slow and obvious.
#pragma once

#include <algorithm>
#include <cmath>

#include "distribute/distribute.h"
#include "lightfield/ray_map.h"
#include "tests/reference/analytic_scene.h"

namespace lamella {

// The paper's weight of a layer, straight from its sentence: linear over the border's width around
// the middle between neighbouring layers.
inline double ReferenceWeight(const Display& display, int layer, double z) {
  const auto in_front = [&](int border) {
    if (border < 0) return 1.0;
    if (border + 1 >= static_cast<int>(display.layers.size())) return 0.0;
    const auto at = [&](int l) { return display.layers[static_cast<std::size_t>(l)].position_mm; };
    const double b = (at(border) + at(border + 1)) / 2 + display.border_offset_mm;
    if (display.border_mm == 0) return z >= b ? 1.0 : 0.0;
    return std::clamp((z - b) / display.border_mm + 0.5, 0.0, 1.0);
  };
  return in_front(layer - 1) - in_front(layer);
}

// m x m x m x m rays a beam: midpoints of cells of the opening and of the emitter. A lens bends all
// light of a point of the emitter into the direction through the opening's middle.
inline EmitterImage ReferenceEmitters(const AnalyticScene& scene, const Display& display, int layer,
                                      int slot, int m, bool lens = false) {
  const RayMap map(display, layer);
  const int k = map.slots_per_axis();
  EmitterImage image{Image<Rgb>(map.columns(), map.rows()),
                     Image<float>(map.columns(), map.rows())};
  const auto cell = [m](int i) { return (i + 0.5) / m - 0.5; };
  for (int row = 0; row < map.rows(); ++row) {
    for (int column = 0; column < map.columns(); ++column) {
      const auto x = map.Column(slot % k, column), y = map.Row(slot / k, row);
      if (!x || !y) continue;
      double light[3] = {0, 0, 0}, coverage = 0;
      for (int i = 0; i < m * m * m * m; ++i) {
        const double ax = cell(i % m), bx = cell(i / m % m), ay = cell(i / m / m % m),
                     by = cell(i / m / m / m);
        const Eigen::Vector3d from(x->emitter_mm + bx * x->emitter_width_mm,
                                   y->emitter_mm + by * y->emitter_width_mm,
                                   map.position_mm() - map.d0_mm());
        const Eigen::Vector3d through(x->element_mm + ax * x->aperture_mm,
                                      y->element_mm + ay * y->aperture_mm, map.position_mm());
        const Eigen::Vector3d middle(x->element_mm, y->element_mm, map.position_mm());
        const RaySample sample =
            scene.Trace(lens ? Ray{through, from - middle} : Ray{from, from - through});
        const double weight = ReferenceWeight(display, layer, static_cast<double>(sample.z)) *
                              static_cast<double>(sample.coverage);
        light[0] += weight * static_cast<double>(sample.color.r);
        light[1] += weight * static_cast<double>(sample.color.g);
        light[2] += weight * static_cast<double>(sample.color.b);
        coverage += static_cast<double>(sample.coverage);
      }
      if (coverage == 0) continue;
      image.color(column, row) = {static_cast<float>(light[0] / coverage),
                                  static_cast<float>(light[1] / coverage),
                                  static_cast<float>(light[2] / coverage)};
      image.coverage(column, row) = static_cast<float>(coverage / (m * m * m * m));
    }
  }
  return image;
}

// PSNR in linear light, peak 1, of emitters that both know.
inline double EmitterPsnr(const EmitterImage& a, const EmitterImage& b) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < a.color.size(); ++i) {
    if (a.coverage.data()[i] == 0 || b.coverage.data()[i] == 0) continue;
    const Rgb d = a.color.data()[i] - b.color.data()[i];
    sum += static_cast<double>(d.r * d.r + d.g * d.g + d.b * d.b);
    count += 3;
  }
  return 10 * std::log10(count / sum);
}

}  // namespace lamella
