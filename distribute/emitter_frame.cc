#include "distribute/emitter_frame.h"

#include <optional>

#include "distribute/panel_pixels-inl.h"
#include "lightfield/lenslet_map.h"

namespace lamella {

Image<Rgb8> EmitterFrame(const EmitterImage& emitters, const Display& display, int layer,
                         const PanelResponse& response) {
  const Layer& shown = display.layers.at(static_cast<std::size_t>(layer));
  std::optional<LensletMap> lenslets;
  if (std::holds_alternative<LensletArray>(shown.optics)) lenslets.emplace(display, layer);
  return PanelFromEmitters<Rgb8>(display, shown, [&](int x, int y) {
    if (!(emitters.coverage(x, y) > 0)) return Rgb8();
    if (lenslets && !lenslets->Pixel(x, y)) return Rgb8();
    const Rgb& light = emitters.color(x, y);
    return Rgb8{response.Code(light.r), response.Code(light.g), response.Code(light.b)};
  });
}

}  // namespace lamella
