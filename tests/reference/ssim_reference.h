// SSIM by its definition: a two-dimensional window around every pixel.
#pragma once

#include <cmath>
#include <optional>

#include "distribute/metrics.h"

namespace lamella::reference {

inline double WindowSsim(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b, int channel, int x,
                         int y) {
  const auto value = [channel](const Rgb8& p) {
    return (channel == 0 ? p.r : channel == 1 ? p.g : p.b) / 255.0;
  };
  const auto mean = [&](auto&& f) {
    double sum = 0, weights = 0;
    for (int v = y - 5; v <= y + 5; ++v) {
      for (int u = x - 5; u <= x + 5; ++u) {
        if (u < 0 || v < 0 || u >= a.width || v >= a.height) continue;
        const double w = std::exp(-((u - x) * (u - x) + (v - y) * (v - y)) / (2 * 1.5 * 1.5));
        sum += w * f(value(a(u, v)), value(b(u, v)));
        weights += w;
      }
    }
    return sum / weights;
  };
  const double ma = mean([](double p, double) { return p; });
  const double mb = mean([](double, double q) { return q; });
  const double va = mean([&](double p, double) { return (p - ma) * (p - ma); });
  const double vb = mean([&](double, double q) { return (q - mb) * (q - mb); });
  const double cov = mean([&](double p, double q) { return (p - ma) * (q - mb); });
  const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  return (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

inline std::optional<double> Ssim(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                                  const MetricRegion& region) {
  double sum = 0;
  int count = 0;
  const int border = region.border_px;
  for (int y = border; y < a.height - border; ++y) {
    for (int x = border; x < a.width - border; ++x) {
      if (region.mask.data != nullptr && region.mask(x, y) < 0.5F) continue;
      for (int channel = 0; channel < 3; ++channel, ++count) {
        sum += WindowSsim(a, b, channel, x, y);
      }
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace lamella::reference
