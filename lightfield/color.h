// sRGB (IEC 61966-2-1) to linear light and back. Called by image_io and by the panel's response
// only, so that every Image<Rgb> is linear.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lightfield/image.h"

namespace lamella {

float SrgbToLinear(
    float encoded);  // [0,1] -> [0,1]; extended linearly below 0 and by the power above 1
float LinearToSrgb(float linear);
float Srgb8ToLinear(std::uint8_t encoded);  // table
std::uint8_t LinearToSrgb8(float linear);   // nearest code, clamped; NaN is 0
void LinearToSrgb8(const float* linear, std::size_t count, std::uint8_t* codes);  // of many

// Of linear light, Rec. 709.
inline float Luminance(const Rgb& light) {
  return 0.2126F * light.r + 0.7152F * light.g + 0.0722F * light.b;
}

}  // namespace lamella
