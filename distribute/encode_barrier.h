// The panels' frames of a parallax barrier layer (displays.md section 2). Frames are final:
// emitters are spread over their pixels, mirrored and encoded, and nothing is resampled.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "distribute/distribute.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// The order in which the k x k slots are shown, as file numbers k * slot_y + slot_x: at time t slot
// (t mod k, (t + floor(t/k)) mod k). Any k consecutive ones touch every row and column of slots.
std::vector<int> SlotOrder(int slots_per_axis);

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

// Of the panel's size. Unknown emitters are black. Not darkened by the number of layers: the optics
// that superpose them do that.
Image<Rgb8> EmitterFrame(const EmitterImage& emitters, const Display& display, int layer,
                         const PanelResponse& response);

// 255 where the modulator is open, 0 elsewhere.
Image<std::uint8_t> ModulatorFrame(const Display& display, int layer, int slot);

}  // namespace lamella
