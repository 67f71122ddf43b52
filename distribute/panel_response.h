// From light to a panel's codes: applied last, since codes are final (displays.md section 5).
#pragma once

#include <array>
#include <cstdint>
#include <functional>

namespace lamella {

// Code of a panel's pixel from linear light: the nearest by the panel's response.
class PanelResponse {
 public:
  static PanelResponse Srgb();
  static PanelResponse Gamma(double exponent);  // light = (code/255)^exponent

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
  std::array<float, 256> above_{};           // least light whose code is larger
  std::array<std::uint8_t, kBins> first_{};  // smallest code in a bin of light
};

}  // namespace lamella
