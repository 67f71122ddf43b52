#include "distribute/encode_barrier.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lightfield/color.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

// Panel pixels from emitters: each fills its bin; the finished row is flipped where the layer is
// seen by reflection.
template <class Pixel, class Source>
Image<Pixel> Spread(const Display& display, bool mirror, Source pixel_of) {
  Image<Pixel> frame(display.width_px, display.height_px);
  const int binning = display.binning_px;
  for (int y = 0; y < display.height_px; ++y) {
    Pixel* row = frame.row(y);
    if (y % binning != 0) {
      std::copy_n(frame.row(y - 1), display.width_px, row);
      continue;
    }
    for (int x = 0; x < display.width_px; ++x) row[x] = pixel_of(x / binning, y / binning);
    if (mirror) std::reverse(row, row + display.width_px);
  }
  return frame;
}

}  // namespace

std::vector<int> SlotOrder(int slots_per_axis) {
  const int k = slots_per_axis;
  std::vector<int> order;
  for (int t = 0; t < k * k; ++t) order.push_back(k * ((t + t / k) % k) + t % k);
  return order;
}

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

Image<Rgb8> EmitterFrame(const EmitterImage& emitters, const Display& display, int layer,
                         const PanelResponse& response) {
  return Spread<Rgb8>(
      display, display.layers[static_cast<std::size_t>(layer)].mirror_x, [&](int x, int y) {
        if (!(emitters.coverage(x, y) > 0)) return Rgb8();
        const Rgb& light = emitters.color(x, y);
        return Rgb8{response.Code(light.r), response.Code(light.g), response.Code(light.b)};
      });
}

Image<std::uint8_t> ModulatorFrame(const Display& display, int layer, int slot) {
  const RayMap map(display, layer);
  const int k = map.slots_per_axis();
  return Spread<std::uint8_t>(
      display, display.layers[static_cast<std::size_t>(layer)].mirror_x, [&](int x, int y) {
        const bool open = map.ColumnOpen(slot % k, x) && map.RowOpen(slot / k, y);
        return static_cast<std::uint8_t>(open ? 255 : 0);
      });
}

}  // namespace lamella
