// Which layer shows a point: the nearest one, with borders that overlap (ranieri2012.md section 6).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "lightfield/display.h"

namespace lamella {

// Weights of layers by the depth of what is seen. Between neighbouring layers, over a width w
// around the border b in their middle, the front one takes t = clamp((z - b + w/2)/w, 0, 1) and the
// back one the rest: the hard choice, averaged over [z - w/2, z + w/2]. The outermost layers reach
// to infinity. Weights are a partition of unity; they act on linear light.
class LayerWeights {
 public:
  // Between a layer and the next one in front of it.
  struct Border {
    float at_mm = 0;
    float per_mm = 0;  // 1/w; 0: hard
    // Share of a point at z that lies in front of it; of NaN nothing does.
    float InFront(float z) const {
      if (per_mm == 0) return z >= at_mm ? 1.0F : 0.0F;
      const float t = (z - at_mm) * per_mm + 0.5F;
      return t > 0 ? (t < 1 ? t : 1.0F) : 0.0F;
    }
  };

  // `positions_mm` rise; 0 <= border_mm <= their smallest spacing (UsageError).
  LayerWeights(std::span<const double> positions_mm, double border_mm);

  int num_layers() const { return static_cast<int>(borders_.size()) + 1; }
  // Borders behind and in front of a layer; none beyond the outermost ones.
  const Border* Behind(int layer) const {
    return layer > 0 ? &borders_[Index(layer - 1)] : nullptr;
  }
  const Border* Before(int layer) const {
    return layer < num_layers() - 1 ? &borders_[Index(layer)] : nullptr;
  }
  // Weight of a layer for a point at z, mm; -inf and +inf allowed.
  float Weight(int layer, float z) const {
    const Border *behind = Behind(layer), *before = Before(layer);
    return (behind != nullptr ? behind->InFront(z) : 1) -
           (before != nullptr ? before->InFront(z) : 0);
  }

 private:
  static std::size_t Index(int i) { return static_cast<std::size_t>(i); }
  std::vector<Border> borders_;
};

// With the display's own borders.
LayerWeights WeightsOf(const Display& display);

}  // namespace lamella
