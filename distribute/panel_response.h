// From light to a panel's codes: applied last, since codes are final (displays.md section 5).
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "lightfield/calibration.h"
#include "lightfield/image.h"

namespace lamella {

// The share of the scene's white that a calibrated display can show everywhere: its layers' whites
// are made alike, so the dimmest colour at the dimmest place of the dimmest one is the measure. 1/n
// of n layers as designed. InputError where a panel's primaries have no inverse.
double CommonWhite(const Calibration& calibration);

// Code of a panel's pixel from linear light: the nearest by the panel's response.
class PanelResponse {
 public:
  static PanelResponse Srgb();
  static PanelResponse Gamma(double exponent);  // light = (code/255)^exponent
  // As measured: the emissive panel's curve and black level, and its part of CommonWhite in the
  // primaries and with the evenness that it has.
  static PanelResponse Of(const Calibration& calibration, int layer);

  Rgb8 Codes(const Rgb& light) const {
    if (!mixes_) return {Code(light.r), Code(light.g), Code(light.b)};
    const auto mixed = [&](std::size_t c) {
      return Code(mix_[c][0] * light.r + mix_[c][1] * light.g + mix_[c][2] * light.b);
    };
    return {mixed(0), mixed(1), mixed(2)};
  }

  // At shares of the panel's width and height (GainAt): brighter light where the panel is dimmer.
  Rgb8 Codes(const Rgb& light, double x, double y) const {
    if (is_even_) return Codes(light);
    return Codes(static_cast<float>(1 / GainAt(evenness_, x, y)) * light);
  }

  // Clamped to the panel's range; NaN is 0.
  std::uint8_t Code(float light) const {
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    std::size_t code = first_[static_cast<std::size_t>(light * kBins)];
    while (light >= above_[code]) ++code;
    return static_cast<std::uint8_t>(code);
  }

 private:
  static constexpr int kBins = 4096;
  explicit PanelResponse(const std::function<double(double)>& light_from_encoded);
  bool mixes_ = false;
  bool is_even_ = true;
  GainMap evenness_;
  std::array<std::array<float, 3>, 3> mix_{};  // the panel's red, green, blue from Rec. 709 light
  std::array<float, 256> above_{};             // least light whose code is larger
  std::array<std::uint8_t, kBins> first_{};    // smallest code in a bin of light
};

}  // namespace lamella
