#include "distribute/emitter_frame.h"

#include "distribute/panel_pixels-inl.h"

namespace lamella {

Image<Rgb8> EmitterFrame(const EmitterImage& emitters, const Display& display, int layer,
                         const PanelResponse& response) {
  return PanelFromEmitters<Rgb8>(display, display.layers[static_cast<std::size_t>(layer)],
                                 emitters.color.height(), [&](int x, int y) {
                                   if (!(emitters.coverage(x, y) > 0)) return Rgb8();
                                   return response.Codes(emitters.color(x, y));
                                 });
}

}  // namespace lamella
