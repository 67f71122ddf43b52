#include "datasets_synthetic/sensor.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "datasets_synthetic/normal_numbers.h"
#include "datasets_synthetic/pixel_points.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

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

// Adds noise to a row's shares of full scale; `index` is that of its first number.
void AddNoise(const Sensor& sensor, const NormalNumbers& normal, std::uint64_t index,
              std::span<float> shares) {
  std::vector<float> noise(shares.size());
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<float>(normal(index + i));
  const auto full_well = static_cast<float>(sensor.full_well_e);
  const auto read_variance = static_cast<float>(sensor.read_noise_e * sensor.read_noise_e);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const float electrons = std::max(0.0F, shares[i] * full_well);
    shares[i] = (electrons + std::sqrt(electrons + read_variance) * noise[i]) / full_well;
  }
}

// A row's shares of full scale, between 0 and 1.
void ExposeRow(const Sensor& sensor, const NormalNumbers& normal, std::span<const float> light,
               std::uint64_t index, std::span<float> shares) {
  const auto exposure = static_cast<float>(sensor.exposure);
  const auto pedestal = static_cast<float>(sensor.pedestal);
  for (std::size_t i = 0; i < light.size(); ++i) shares[i] = exposure * light[i];
  if (sensor.full_well_e > 0) AddNoise(sensor, normal, index, shares);
  for (float& share : shares) share = std::min(std::max(share + pedestal, 0.0F), 1.0F);
}

void EncodeRow(const Sensor& sensor, std::span<const float> shares, std::span<float> numbers) {
  if (sensor.curve == Sensor::Curve::kSrgb && sensor.bits == 8) {
    std::vector<std::uint8_t> codes(shares.size());
    LinearToSrgb8(shares.data(), shares.size(), codes.data());
    for (std::size_t i = 0; i < codes.size(); ++i) numbers[i] = static_cast<float>(codes[i]) / 255;
    return;
  }
  const double codes = sensor.bits > 0 ? static_cast<double>((1 << sensor.bits) - 1) : 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double number = Encoded(sensor, static_cast<double>(shares[i]));
    numbers[i] = static_cast<float>(codes > 0 ? std::round(number * codes) / codes : number);
  }
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
  const NormalNumbers normal;
  const std::uint64_t first = MixedHash(seed);
  const auto width = 3 * static_cast<std::size_t>(light.width);
  ParallelForEach(0, light.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    std::vector<float> shares(width);
    ExposeRow(sensor, normal, {&light.row(y)->r, width},
              first + static_cast<std::uint64_t>(row) * width, shares);
    EncodeRow(sensor, shares, {&numbers.row(y)->r, width});
  });
  return numbers;
}

}  // namespace lamella
