#include "distribute/seen_layer.h"

#include <variant>

namespace lamella {
namespace {

bool IsBehindLenses(const Display& display, int layer) {
  const Optics& optics = display.layers[static_cast<std::size_t>(layer)].optics;
  return std::holds_alternative<LensletArray>(optics) || std::holds_alternative<Lenticular>(optics);
}

}  // namespace

std::unique_ptr<LayerSeen> SeeLayer(const EmitterStrip& strip, const Display& display, int layer,
                                    const Eye& eye, const RowRange& rows) {
  return IsBehindLenses(display, layer) ? SeeThroughLenses(strip, display, layer, eye, rows)
                                        : SeeThroughOpenings(strip, display, layer, eye);
}

std::vector<RowRange> SeenEmitterRows(const Display& display, int layer, const Eye& eye) {
  return IsBehindLenses(display, layer) ? RowsThroughLenses(display, layer, eye)
                                        : RowsThroughOpenings(display, layer, eye);
}

}  // namespace lamella
