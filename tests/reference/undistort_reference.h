// The resampling of pipeline/poses/undistort.h, pixel by pixel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "lightfield/camera.h"
#include "lightfield/image.h"

namespace lamella::reference {

using Eigen::Vector2d;
using Eigen::Vector3d;

inline Vector3d DirectionOf(const Camera& pinhole, const Vector2d& pixel) {
  return {(pixel.x() - pinhole.cx) / pinhole.fx, (pixel.y() - pinhole.cy) / pinhole.fy, 1};
}

// Catmull-Rom (Keys 1981, a = -1/2).
inline double Cubic(double x) {
  x = std::abs(x);
  if (x < 1) return (1.5 * x - 2.5) * x * x + 1;
  if (x < 2) return ((-0.5 * x + 2.5) * x - 4) * x + 2;
  return 0;
}

// The samples of one axis that make up a value, and their weights, which sum to 1.
struct Taps {
  static constexpr int kMost = 64;
  int first = 0, count = 0;
  std::array<float, kMost> weights;

  // `position` in continuous coordinates; `scale` >= 1 widens the kernel.
  Taps(double position, double scale) {
    const double radius = std::min(2 * scale, kMost / 2.0 - 1);
    first = static_cast<int>(std::ceil(position - 0.5 - radius));
    const int last = static_cast<int>(std::floor(position - 0.5 + radius));
    count = last - first + 1;
    double sum = 0;
    std::array<double, kMost> raw;
    for (int i = 0; i < count; ++i) {
      raw[static_cast<std::size_t>(i)] = Cubic((first + i + 0.5 - position) * 2 / radius);
      sum += raw[static_cast<std::size_t>(i)];
    }
    for (int i = 0; i < count; ++i) {
      weights[static_cast<std::size_t>(i)] =
          static_cast<float>(raw[static_cast<std::size_t>(i)] / sum);
    }
  }
};

inline Rgb SampleWide(const Image<Rgb>& image, const Vector2d& position, double scale) {
  const Taps across(std::clamp(position.x(), 0.0, 1.0 * image.width()), scale);
  const Taps down(std::clamp(position.y(), 0.0, 1.0 * image.height()), scale);
  Rgb sum;
  for (int j = 0; j < down.count; ++j) {
    const Rgb* row = image.row(std::clamp(down.first + j, 0, image.height() - 1));
    Rgb line;
    for (int i = 0; i < across.count; ++i) {
      const int x = std::clamp(across.first + i, 0, image.width() - 1);
      line += across.weights[static_cast<std::size_t>(i)] * row[x];
    }
    sum += down.weights[static_cast<std::size_t>(j)] * line;
  }
  return sum;
}

// The weights of the samples -1, 0, 1, 2 at `t` in [0, 1) after sample 0: Cubic in closed form.
inline std::array<float, 4> FourWeights(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {-0.5F * t3 + t2 - 0.5F * t, 1.5F * t3 - 2.5F * t2 + 1, -1.5F * t3 + 2 * t2 + 0.5F * t,
          0.5F * t3 - 0.5F * t2};
}

// As SampleWide with scale 1, where all 16 samples lie in the image.
inline Rgb SampleSharp(const Image<Rgb>& image, int x0, int y0, float tx, float ty) {
  const std::array<float, 4> across = FourWeights(tx), down = FourWeights(ty);
  Rgb sum;
  for (int j = 0; j < 4; ++j) {
    const Rgb* p = image.row(y0 - 1 + j) + (x0 - 1);
    const float w0 = across[0], w1 = across[1], w2 = across[2], w3 = across[3];
    const Rgb line = {w0 * p[0].r + w1 * p[1].r + w2 * p[2].r + w3 * p[3].r,
                      w0 * p[0].g + w1 * p[1].g + w2 * p[2].g + w3 * p[3].g,
                      w0 * p[0].b + w1 * p[1].b + w2 * p[2].b + w3 * p[3].b};
    sum += down[static_cast<std::size_t>(j)] * line;
  }
  return sum;
}

inline Rgb Sample(const Image<Rgb>& image, const Vector2d& position, double scale) {
  const double x = position.x() - 0.5, y = position.y() - 0.5;
  const bool inside = x >= 1 && y >= 1 && x < image.width() - 2 && y < image.height() - 2;
  if (scale > 1 || !inside) return SampleWide(image, position, scale);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  return SampleSharp(image, x0, y0, static_cast<float>(x - x0), static_cast<float>(y - y0));
}

using Sources = std::vector<std::optional<Vector2d>>;

// Where the original shows the pixels of a row: every `step`-th exactly, those between by the cubic
// through four of them. A step is at most 1/256 of the focal length, so that lenses stray from it
// by less than 1e-5 px.
inline Sources SourcesOfRow(const Camera& camera, const Camera& pinhole, int y) {
  const auto exact = [&](int x) {
    return Project(camera, DirectionOf(pinhole, {x + 0.5, y + 0.5}));
  };
  const int step = std::clamp(static_cast<int>(pinhole.fx / 256), 1, 16);
  Sources knots;  // of the pixels -step, 0, step, ...
  for (int i = 0; i < (pinhole.width - 1) / step + 4; ++i) knots.push_back(exact((i - 1) * step));
  Sources sources;
  for (int x = 0; x < pinhole.width; ++x) {
    const auto* k = &knots[static_cast<std::size_t>(x / step)];
    const double t = static_cast<double>(x % step) / step;
    if (t == 0) {
      sources.push_back(k[1]);
    } else if (k[0] && k[1] && k[2] && k[3]) {
      sources.emplace_back(t * (t - 1) * ((1 + t) * *k[3] - (t - 2) * *k[0]) / 6 +
                           (t + 1) * (t - 2) * ((t - 1) * *k[1] - t * *k[2]) / 2);
    } else {
      sources.push_back(exact(x));
    }
  }
  return sources;
}

inline Image<Rgb> Undistort(const Image<Rgb>& image, const Camera& camera, const Camera& pinhole) {
  Image<Rgb> result(pinhole.width, pinhole.height);
  const double scale = std::max(1.0, camera.fx / pinhole.fx);
  for (int y = 0; y < pinhole.height; ++y) {
    const Sources sources = SourcesOfRow(camera, pinhole, y);
    for (int x = 0; x < pinhole.width; ++x) {
      const auto& source = sources[static_cast<std::size_t>(x)];
      if (source) result(x, y) = Sample(image, *source, scale);
    }
  }
  return result;
}

}  // namespace lamella::reference
