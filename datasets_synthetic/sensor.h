// A camera's sensor: from the light on its pixels to the numbers of a photograph.
#pragma once

#include <cstdint>

#include "lightfield/image.h"

namespace lamella {

struct Sensor {
  double exposure = 1;      // light of 1/exposure fills the wells
  double full_well_e = 0;   // electrons of a full well; 0: no noise at all
  double read_noise_e = 0;  // standard deviation, electrons; used with full_well_e
  double pedestal = 0;      // added before the curve, share of full scale, as raw converters do
  enum class Curve { kLinear, kSrgb, kGamma };
  Curve curve = Curve::kLinear;
  double gamma = 2.2;  // kGamma: number = light^(1/gamma)
  int bits = 0;        // 8 to 16: rounded to whole codes; 0: not rounded
};

// Numbers in [0, 1] of full scale. With e electrons of signal the noise is normal with variance
// e + read_noise_e^2 (the Gaussian limit of shot noise), equal for equal seed, pixel and channel.
// UsageError where a number is out of range.
Image<Rgb> Develop(ImageSpan<const Rgb> light, const Sensor& sensor, std::uint64_t seed);

}  // namespace lamella
