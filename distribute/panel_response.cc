#include "distribute/panel_response.h"

#include <cmath>
#include <limits>

#include "lightfield/color.h"

namespace lamella {

PanelResponse::PanelResponse(const std::function<double(double)>& light_from_encoded) {
  for (std::size_t code = 0; code < 255; ++code) {
    above_[code] = static_cast<float>(light_from_encoded((static_cast<double>(code) + 0.5) / 255));
  }
  above_[255] = std::numeric_limits<float>::infinity();
  std::size_t code = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    while (static_cast<float>(bin) / kBins >= above_[code]) ++code;
    first_[bin] = static_cast<std::uint8_t>(code);
  }
}

PanelResponse PanelResponse::Srgb() {
  return PanelResponse([](double encoded) {
    return static_cast<double>(SrgbToLinear(static_cast<float>(encoded)));
  });
}

PanelResponse PanelResponse::Gamma(double exponent) {
  return PanelResponse([exponent](double encoded) { return std::pow(encoded, exponent); });
}

}  // namespace lamella
