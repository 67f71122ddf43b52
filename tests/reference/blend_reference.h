// What a view adds to a tile's rays, ray by ray and in double: the formulas of
// depth/blend_kernels.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "depth/blend_kernels.h"

namespace lamella::reference {

// Value of an IEEE 754 binary16.
inline double FromHalf(std::uint16_t half) {
  const int exponent = half >> 10, mantissa = half & 0x3FF;
  return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
}

struct RayInView {
  double x = 0, y = 0, inverse_depth = 0, m = 0;
};

inline RayInView Place(const TileView& view, double du, double dv, double n) {
  const LocalMap& l = view.view_from_tile;
  const double dn = n - static_cast<double>(view.at_nearness);
  const auto linear = [&](float middle, float per_u, float per_v, float per_n, double nearness) {
    return static_cast<double>(middle) + static_cast<double>(per_u) * du +
           static_cast<double>(per_v) * dv + static_cast<double>(per_n) * nearness;
  };
  const double m = linear(l.m0, l.ma, l.mb, l.mc, dn);
  const double x = linear(l.x_0, l.xa, l.xb, l.xc, dn);
  const double y = linear(l.y_0, l.ya, l.yb, l.yc, dn);
  const double q = linear(l.q_0, l.qa, l.qb, l.qc, n);
  return {static_cast<double>(l.x0) + x / m, static_cast<double>(l.y0) + y / m, q / m, m};
}

struct Look {
  double visible = 0, confidence = 0;
  bool known = false;
};

inline Look LookAt(const TileView& view, double x, double y, double w) {
  const DepthLevel& level = *view.depth;
  const double px = x * level.per_color_x + 0.5, py = y * level.per_color_y + 0.5;
  const int cx = std::min(static_cast<int>(px), level.width);
  const int cy = std::min(static_cast<int>(py), level.height);
  const auto at = [&](int i, int j) {
    return static_cast<double>(level.inverse_depth(cx + i, cy + j));
  };
  const double s = px - cx, t = py - cy;
  double there = std::max({at(0, 0), at(1, 0), at(0, 1), at(1, 1)});
  if (level.smooth(cx, cy) != 0) {
    there = (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
  }
  Look look;
  look.known = there >= 0;
  look.confidence =
      static_cast<double>(level.confidence(cx + (s >= 0.5 ? 1 : 0), cy + (t >= 0.5 ? 1 : 0)));
  if (!look.known) return look;
  const double softness =
      static_cast<double>(view.softness_absolute) + static_cast<double>(view.softness_relative) * w;
  const double q = (there - w) / softness;
  look.visible = std::pow(std::max(0.0, 1 - q * q / 8), 4);
  return look;
}

inline double Tap(double distance, bool cubic) {  // of Catmull-Rom or of linear interpolation
  const double d = std::abs(distance);
  if (!cubic) return std::max(0.0, 1 - d);
  if (d < 1) return 1.5 * d * d * d - 2.5 * d * d + 1;
  if (d < 2) return -0.5 * d * d * d + 2.5 * d * d - 4 * d + 2;
  return 0;
}

// A channel (0, 1, 2) of a level at a picture position.
inline double ColorAt(const ColorLevel& level, bool cubic, double x, double y, int channel) {
  const double px = x * static_cast<double>(level.scale_x) - 0.5,
               py = y * static_cast<double>(level.scale_y) - 0.5;
  double sum = 0;
  for (int v = -ColorLevel::kPad; v < level.height + ColorLevel::kPad; ++v) {
    if (std::abs(v - py) >= 2) continue;
    for (int u = -ColorLevel::kPad; u < level.width + ColorLevel::kPad; ++u) {
      if (std::abs(u - px) >= 2) continue;
      const ColorLevel::Pixel& p = level.pixels(u + ColorLevel::kPad, v + ColorLevel::kPad);
      const double value = FromHalf(channel == 0 ? p.r : channel == 1 ? p.g : p.b);
      sum += Tap(u - px, cubic) * Tap(v - py, cubic) * value;
    }
  }
  return std::max(0.0, sum);
}

// What the view adds to ray i.
struct Added {
  double weight = 0, visible = 0, confidence = 0;
  double x = 0, y = 0;
};

inline Added Add(const TileView& view, double du, double dv, double n) {
  const RayInView ray = Place(view, du, dv, n);
  Added added;
  if (!(ray.m > 0)) return added;
  const double width = static_cast<double>(view.width), height = static_cast<double>(view.height);
  const double inside = std::min({ray.x, width - ray.x, ray.y, height - ray.y});
  added.x = std::clamp(ray.x, 0.0, width);
  added.y = std::clamp(ray.y, 0.0, height);
  const double s = du / kTile + 0.5, t = dv / kTile + 0.5;
  const auto corner = [&](std::size_t k) { return static_cast<double>(view.penalty[k]); };
  const double penalty =
      (1 - t) * ((1 - s) * corner(0) + s * corner(1)) + t * ((1 - s) * corner(2) + s * corner(3));
  const double direction = 1 / (0.02 + penalty);
  if (inside < 0) {
    added.weight = direction * 1e-6 / (1 + inside * inside);
    return added;
  }
  const Look look = LookAt(view, added.x, added.y, ray.inverse_depth);
  const double fade = std::min(1.0, (inside + 0.5) * static_cast<double>(view.per_fade));
  added.visible = look.visible;
  added.weight = direction * fade * (look.visible + (look.known ? 1e-4 : 1e-2));
  added.confidence = direction * fade * look.visible * look.confidence;
  return added;
}

}  // namespace lamella::reference
