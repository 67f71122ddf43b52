#include "distribute/assign.h"

#include <cmath>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {

LayerWeights::LayerWeights(std::span<const double> positions_mm, double border_mm) {
  const float per_mm = 1 / static_cast<float>(border_mm);
  for (std::size_t i = 1; i < positions_mm.size(); ++i) {
    const double spacing = positions_mm[i] - positions_mm[i - 1];
    constexpr double kRounding = 1e-9;  // of positions
    if (!(border_mm >= 0 && border_mm <= spacing * (1 + kRounding))) {
      throw UsageError(
          "--border-mm",
          fmt::format("{:g} mm between layers that are {:g} mm apart", border_mm, spacing),
          "give 0 or more, at most the layers' spacing");
    }
    borders_.push_back({static_cast<float>((positions_mm[i] + positions_mm[i - 1]) / 2),
                        std::isfinite(per_mm) ? per_mm : 0});
  }
}

LayerWeights WeightsOf(const Display& display) {
  std::vector<double> positions;
  for (const Layer& layer : display.layers) {
    positions.push_back(layer.position_mm + display.border_offset_mm);
  }
  return {positions, display.border_mm};
}

}  // namespace lamella
