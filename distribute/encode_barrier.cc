#include "distribute/encode_barrier.h"

#include "distribute/panel_pixels-inl.h"
#include "lightfield/ray_map.h"

namespace lamella {

std::vector<int> SlotOrder(int slots_per_axis) {
  const int k = slots_per_axis;
  std::vector<int> order;
  for (int t = 0; t < k * k; ++t) order.push_back(k * ((t + t / k) % k) + t % k);
  return order;
}

Image<std::uint8_t> ModulatorFrame(const Display& display, int layer, int slot, int first_row,
                                   int end_row) {
  const RayMap map(display, layer);
  const int k = map.slots_per_axis();
  return PanelFromEmitters<std::uint8_t>(display, display.layers[static_cast<std::size_t>(layer)],
                                         end_row - first_row, [&](int x, int y) {
                                           const bool open = map.ColumnOpen(slot % k, x) &&
                                                             map.RowOpen(slot / k, first_row + y);
                                           return static_cast<std::uint8_t>(open ? 255 : 0);
                                         });
}

Image<std::uint8_t> ModulatorFrame(const Display& display, int layer, int slot) {
  return ModulatorFrame(display, layer, slot, 0, display.emitter_rows());
}

}  // namespace lamella
