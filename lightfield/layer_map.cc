#include "lightfield/layer_map.h"

namespace lamella {
namespace {

std::variant<RayMap, LensletMap, LenticularMap> MapOf(const Display& display, int layer) {
  const Optics& optics = display.layers.at(static_cast<std::size_t>(layer)).optics;
  if (std::holds_alternative<LensletArray>(optics)) return LensletMap(display, layer);
  if (std::holds_alternative<Lenticular>(optics)) return LenticularMap(display, layer);
  return RayMap(display, layer);
}

}  // namespace

LayerMap::LayerMap(const Display& display, int layer)
    : map_(MapOf(display, layer)),
      position_mm_(display.layers[static_cast<std::size_t>(layer)].position_mm) {}

std::optional<Beam> LayerMap::BeamOf(int slot, int channel, int column, int row) const {
  if (const RayMap* barrier = std::get_if<RayMap>(&map_)) {
    const int k = barrier->slots_per_axis();
    const std::optional<AxisBeam> x = barrier->Column(slot % k, column);
    const std::optional<AxisBeam> y = barrier->Row(slot / k, row);
    return x && y ? std::optional<Beam>({*x, *y}) : std::nullopt;
  }
  if (const LensletMap* lenslets = std::get_if<LensletMap>(&map_)) {
    return lenslets->BeamOf(column, row);
  }
  return std::get<LenticularMap>(map_).BeamOf(channel, column, row);
}

std::optional<Sight> LayerMap::See(double x_mm, double y_mm, double slope_x, double slope_y) const {
  return std::visit([&](const auto& map) { return map.See(x_mm, y_mm, slope_x, slope_y); }, map_);
}

}  // namespace lamella
