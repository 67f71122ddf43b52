#include "datasets_synthetic/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "datasets_synthetic/pixel_points.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// A standard normal number (Box and Muller 1958).
double Normal(std::uint64_t index) {
  const std::uint64_t a = MixedHash(index), b = MixedHash(a);
  const double u = (static_cast<double>(a >> 11) + 0.5) / 9007199254740992.0;
  const double v = (static_cast<double>(b >> 11) + 0.5) / 9007199254740992.0;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

double Encoded(const Sensor& sensor, double share) {
  switch (sensor.curve) {
    case Sensor::Curve::kLinear:
      return share;
    case Sensor::Curve::kSrgb:
      return static_cast<double>(LinearToSrgb(static_cast<float>(share)));
    case Sensor::Curve::kGamma:
      break;
  }
  return std::pow(share, 1 / sensor.gamma);
}

float Number(const Sensor& sensor, float light, std::uint64_t index) {
  double share = sensor.exposure * static_cast<double>(light);
  if (sensor.full_well_e > 0) {
    const double electrons = std::max(0.0, share * sensor.full_well_e);
    const double variance = electrons + sensor.read_noise_e * sensor.read_noise_e;
    share = (electrons + std::sqrt(variance) * Normal(index)) / sensor.full_well_e;
  }
  const double number = Encoded(sensor, std::clamp(share + sensor.pedestal, 0.0, 1.0));
  if (sensor.bits == 0) return static_cast<float>(number);
  const double codes = static_cast<double>((1 << sensor.bits) - 1);
  return static_cast<float>(std::round(number * codes) / codes);
}

void Require(bool holds, const char* name, double value) {
  if (!holds) {
    throw UsageError("sensor", fmt::format("{} = {} is out of range", name, value),
                     "give another number");
  }
}

}  // namespace

Image<Rgb> Develop(ImageSpan<const Rgb> light, const Sensor& sensor, std::uint64_t seed) {
  Require(sensor.exposure > 0 && std::isfinite(sensor.exposure), "exposure", sensor.exposure);
  Require(sensor.full_well_e >= 0 && std::isfinite(sensor.full_well_e), "full_well_e",
          sensor.full_well_e);
  Require(sensor.read_noise_e >= 0 && std::isfinite(sensor.read_noise_e), "read_noise_e",
          sensor.read_noise_e);
  Require(sensor.pedestal >= 0 && sensor.pedestal < 1, "pedestal", sensor.pedestal);
  Require(sensor.gamma > 0 && std::isfinite(sensor.gamma), "gamma", sensor.gamma);
  Require(sensor.bits == 0 || (sensor.bits >= 8 && sensor.bits <= 16), "bits", sensor.bits);
  Image<Rgb> numbers(light.width, light.height);
  const std::uint64_t first = MixedHash(seed);
  ParallelForEach(0, light.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    std::uint64_t index = first + 3 * static_cast<std::uint64_t>(row * light.width);
    for (int x = 0; x < light.width; ++x, index += 3) {
      const Rgb& l = light(x, y);
      numbers(x, y) = {Number(sensor, l.r, index), Number(sensor, l.g, index + 1),
                       Number(sensor, l.b, index + 2)};
    }
  });
  return numbers;
}

}  // namespace lamella
