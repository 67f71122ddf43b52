#include "lightfield/color.h"

#include <algorithm>
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
    Bucket bucket{0, FirstOf(1)};
    for (std::uint32_t i = 0; i < kBuckets; ++i) {
      const std::int32_t code = Rounded(std::bit_cast<float>(kLowest + (i << kShift)));
      if (code != bucket.code) bucket = {code, code < 255 ? FirstOf(code + 1) : 2.0F};
      buckets_[i] = bucket;
    }
  }

  std::uint8_t operator()(float linear) const {
    const float above = linear > std::bit_cast<float>(kLowest) ? linear : 0.0F;  // also NaN
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(std::min(above, kBelowOne));
    const Bucket& bucket = buckets_[(std::max(bits, kLowest) - kLowest) >> kShift];
    return static_cast<std::uint8_t>(bucket.code + (std::bit_cast<float>(bits) >= bucket.next));
  }

 private:
  static constexpr std::uint32_t kLowest = 0x39000000;  // 2^-13; code 1 begins at 1.26 times that
  static constexpr std::uint32_t kOne = 0x3f800000;
  static constexpr float kBelowOne = std::bit_cast<float>(kOne - 1);  // of code 255, too
  static constexpr int kShift = 16;
  static constexpr std::uint32_t kBuckets = (kOne - kLowest) >> kShift;

  struct Bucket {
    std::int32_t code = 0;  // at its begin
    float next = 0;         // the least float of the code after that
  };

  static std::int32_t Rounded(float linear) {
    return static_cast<std::int32_t>(std::lround(LinearToSrgb(linear) * 255.0F));
  }

  // The least float of the code.
  static float FirstOf(std::int32_t code) {
    std::uint32_t below = kLowest, at = kOne;
    while (at - below > 1) {
      const std::uint32_t middle = below + (at - below) / 2;
      (Rounded(std::bit_cast<float>(middle)) >= code ? at : below) = middle;
    }
    return std::bit_cast<float>(at);
  }

  std::array<Bucket, kBuckets> buckets_{};
};

const Encoder& TheEncoder() {
  static const Encoder encoder;
  return encoder;
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

std::uint8_t LinearToSrgb8(float linear) { return TheEncoder()(linear); }

void LinearToSrgb8(const float* linear, std::size_t count, std::uint8_t* codes) {
  const Encoder& encoder = TheEncoder();
  for (std::size_t i = 0; i < count; ++i) codes[i] = encoder(linear[i]);
}

}  // namespace lamella
