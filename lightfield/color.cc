#include "lightfield/color.h"

#include <array>
#include <bit>
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

// Codes by the leading bits of a float: a bucket, 1/128 of its values wide, holds one step at most.
class Encoder {
 public:
  Encoder() {
    for (int code = 1; code < 256; ++code) first_[Index(code)] = FirstOf(code);
    first_[256] = 2;
    for (std::uint32_t bucket = 0; bucket < kBuckets; ++bucket) {
      code_[bucket] = Rounded(std::bit_cast<float>(kLowest + (bucket << kShift)));
    }
  }

  std::uint8_t operator()(float linear) const {
    const auto bits = std::bit_cast<std::uint32_t>(linear);
    if (bits < kLowest) return 0;
    const int code = code_[(bits - kLowest) >> kShift];
    return static_cast<std::uint8_t>(code + (linear >= first_[Index(code + 1)] ? 1 : 0));
  }

 private:
  static constexpr std::uint32_t kLowest = 0x39000000;  // 2^-13; code 1 begins at 1.26 times that
  static constexpr std::uint32_t kOne = 0x3f800000;
  static constexpr int kShift = 16;
  static constexpr std::uint32_t kBuckets = (kOne - kLowest) >> kShift;

  static std::size_t Index(int code) { return static_cast<std::size_t>(code); }

  static std::uint8_t Rounded(float linear) {
    return static_cast<std::uint8_t>(std::lround(LinearToSrgb(linear) * 255.0F));
  }

  // The least float of the code.
  static float FirstOf(int code) {
    std::uint32_t below = kLowest, at = kOne;
    while (at - below > 1) {
      const std::uint32_t middle = below + (at - below) / 2;
      (Rounded(std::bit_cast<float>(middle)) >= code ? at : below) = middle;
    }
    return std::bit_cast<float>(at);
  }

  std::array<float, 257> first_{};  // of code 256: beyond all
  std::array<std::uint8_t, kBuckets> code_{};
};

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
  static const Encoder encoder;
  return encoder(linear);
}

}  // namespace lamella
