#include "distribute/emitter_frame.h"

#include "distribute/panel_pixels-inl.h"

namespace lamella {

Image<Rgb8> EmitterFrame(const EmitterImage& emitters, const Display& display, int layer,
                         const PanelResponse& response, int first_row) {
  const Layer& of = display.layers[static_cast<std::size_t>(layer)];
  return PanelFromEmitters<Rgb8>(display, of, emitters.color.height(), [&](int x, int y) {
    if (!(emitters.coverage(x, y) > 0)) return Rgb8();
    const double across = (x + 0.5) / display.emitter_columns();
    return response.Codes(emitters.color(x, y), of.mirror_x ? 1 - across : across,
                          (first_row + y + 0.5) / display.emitter_rows());
  });
}

}  // namespace lamella
