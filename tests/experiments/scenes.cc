#include "tests/experiments/scenes.h"

#include <algorithm>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

namespace lamella::experiments {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Wave {
  double kx = 0, ky = 0, phase = 0, amplitude = 0;
};

// Frequencies uniform in log f have the power of 1/f; their sum has the standard deviation 0.16.
std::vector<Wave> RandomWaves(unsigned seed, int count, bool along_x) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Wave> waves;
  for (int i = 0; i < count; ++i) {
    const double f = 0.02 * std::pow(0.8 / 0.02, (i + unit(random)) / count);
    const double angle = along_x ? 0 : kTwoPi * unit(random);
    waves.push_back({kTwoPi * f * std::cos(angle), kTwoPi * f * std::sin(angle),
                     kTwoPi * unit(random), 0.16 * std::sqrt(2.0 / count)});
  }
  return waves;
}

}  // namespace

void SceneAlongX::Query(const RayBundle& bundle, const Rect& rectangle,
                        ImageSpan<RaySample> samples) const {
  for (int i = 0; i < rectangle.width; ++i) {
    const Ray ray = bundle.RayAt(rectangle.x + i + 0.5, rectangle.y + 0.5);
    const double slope = ray.direction.x() / ray.direction.z();
    const Seen seen = trace_(ray.origin.x() - slope * ray.origin.z(), slope);
    const float value = static_cast<float>(seen.radiance);
    samples(i, 0) = {{value, value, value}, static_cast<float>(seen.z - bundle.origin.z()), 1, 1};
  }
  for (int j = 1; j < rectangle.height; ++j) {
    std::copy_n(samples.row(0), rectangle.width, samples.row(j));
  }
}

SceneAlongX PlaneOfWaves(double z, std::vector<double> frequencies) {
  return SceneAlongX([z, frequencies = std::move(frequencies)](double x0, double slope) {
    double value = 0.5;
    for (const double f : frequencies) value += std::cos(kTwoPi * f * (x0 + slope * z));
    return Seen{value, z};
  });
}

std::function<double(double)> TextureAlongX(unsigned seed) {
  return [waves = RandomWaves(seed, 48, true)](double x) {
    double value = 0.5;
    for (const Wave& w : waves) value += w.amplitude * std::cos(w.kx * x + w.phase);
    return std::clamp(value, 0.0, 1.0);
  };
}

std::function<double(double, double)> Texture(unsigned seed) {
  constexpr int kSize = 640;
  constexpr double kStepMm = 0.06;
  auto table = std::make_shared<Image<float>>(kSize + 1, kSize + 1);
  const std::vector<Wave> waves = RandomWaves(seed, 48, false);
  for (int j = 0; j <= kSize; ++j) {
    for (int i = 0; i <= kSize; ++i) {
      double value = 0.5;
      for (const Wave& w : waves) {
        value += w.amplitude * std::cos((w.kx * i + w.ky * j) * kStepMm + w.phase);
      }
      (*table)(i, j) = static_cast<float>(std::clamp(value, 0.0, 1.0));
    }
  }
  return [table](double x, double y) {
    const auto place = [](double mm) {
      const double at = mm / kStepMm + kSize / 2.0;
      return at - kSize * std::floor(at / kSize);
    };
    const double u = place(x), v = place(y);
    const int i = std::min(static_cast<int>(u), kSize - 1);
    const int j = std::min(static_cast<int>(v), kSize - 1);
    const double s = u - i, t = v - j;
    const auto at = [&](int di, int dj) { return static_cast<double>((*table)(i + di, j + dj)); };
    return (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
  };
}

}  // namespace lamella::experiments
