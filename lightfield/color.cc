#include "lightfield/color.h"

#include <array>
#include <cmath>

namespace lamella {
namespace {

std::array<float, 256> DecodeTable() {
  std::array<float, 256> table{};
  for (int code = 0; code < 256; ++code) {
    table[static_cast<std::size_t>(code)] = SrgbToLinear(static_cast<float>(code) / 255.0F);
  }
  return table;
}

}  // namespace

float SrgbToLinear(float encoded) {
  if (encoded <= 0.04045F) return encoded / 12.92F;
  return std::pow((encoded + 0.055F) / 1.055F, 2.4F);
}

float LinearToSrgb(float linear) {
  if (linear <= 0.0031308F) return linear * 12.92F;
  return 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F;
}

float Srgb8ToLinear(std::uint8_t encoded) {
  static const std::array<float, 256> table = DecodeTable();
  return table[encoded];
}

std::uint8_t LinearToSrgb8(float linear) {
  if (!(linear > 0.0F)) return 0;  // also NaN
  if (linear >= 1.0F) return 255;
  return static_cast<std::uint8_t>(std::lround(LinearToSrgb(linear) * 255.0F));
}

}  // namespace lamella
