// Distribution as ranieri2012.md section 4 states it: many rays in every emitter's beam, each asked
// on its own, weighted and averaged. Slow and obvious.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "distribute/distribute.h"
#include "lightfield/layer_map.h"
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

// Rays of a beam from places of the emitter, b, through places of the element, a, both shares of
// their widths in [-1/2, 1/2]: displays.md section 1.3 with kappa = 1/d0 - 1/f.
inline Ray ReferenceRay(const Beam& beam, double layer_mm, const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b, bool lens) {
  const auto slope = [lens](const AxisBeam& axis, double at, double from) {
    const double kappa = lens ? 0 : 1 / axis.d0_mm - axis.power_per_mm;
    return (axis.element_mm - axis.emitter_mm - from * axis.emitter_width_mm) / axis.d0_mm +
           kappa * at * axis.aperture_mm;
  };
  return {{beam.x.element_mm + a.x() * beam.x.aperture_mm,
           beam.y.element_mm + a.y() * beam.y.aperture_mm, layer_mm},
          -Eigen::Vector3d(slope(beam.x, a.x(), b.x()), slope(beam.y, a.y(), b.y()), 1)};
}

// m x m x m x m rays a beam: midpoints of cells of the element and of the emitter. `lens`: as if
// each element bent all light of a point of the emitter into the direction through its own middle.
// Colours are those of one channel's beam where sub-pixels differ.
inline EmitterImage ReferenceEmitters(const AnalyticScene& scene, const Display& display, int layer,
                                      int slot, int m, bool lens = false, int channel = 0) {
  const LayerMap map(display, layer);
  EmitterImage image{Image<Rgb>(display.emitter_columns(), display.emitter_rows()),
                     Image<float>(display.emitter_columns(), display.emitter_rows())};
  const auto cell = [m](int i) { return (i + 0.5) / m - 0.5; };
  for (int row = 0; row < image.color.height(); ++row) {
    for (int column = 0; column < image.color.width(); ++column) {
      const std::optional<Beam> beam = map.BeamOf(slot, channel, column, row);
      if (!beam) continue;
      double light[3] = {0, 0, 0}, coverage = 0;
      for (int i = 0; i < m * m * m * m; ++i) {
        const RaySample sample =
            scene.Trace(ReferenceRay(*beam, map.position_mm(), {cell(i % m), cell(i / m / m % m)},
                                     {cell(i / m % m), cell(i / m / m / m)}, lens));
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
