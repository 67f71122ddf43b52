// Which layer shows a point: the nearest one, with borders that overlap (ranieri2012.md section 6).
#pragma once

#include <span>
#include <vector>

namespace lamella {

// Weights of layers by the depth of what is seen. Between neighbouring layers, over a width w
// around the border b in their middle, the front one takes t = clamp((z - b + w/2)/w, 0, 1) and the
// back one the rest: the hard choice, averaged over [z - w/2, z + w/2]. The outermost layers reach
// to infinity. Weights are a partition of unity; they act on linear light.
class LayerWeights {
 public:
  // `positions_mm` rise; 0 <= border_mm <= their smallest spacing (UsageError).
  LayerWeights(std::span<const double> positions_mm, double border_mm);

  int num_layers() const { return static_cast<int>(borders_.size()) + 1; }
  // Weight of a layer for a point at z, mm; -inf and +inf allowed.
  float Weight(int layer, float z) const { return InFrontOf(layer - 1, z) - InFrontOf(layer, z); }

 private:
  // Share of the point that lies in front of border i (between layers i and i + 1).
  float InFrontOf(int i, float z) const {
    if (i < 0) return 1;
    if (i >= static_cast<int>(borders_.size())) return 0;
    const float border = borders_[static_cast<std::size_t>(i)];
    if (border_mm_ == 0) return z >= border ? 1.0F : 0.0F;
    const float t = (z - border) / border_mm_ + 0.5F;
    return t > 0 ? (t < 1 ? t : 1.0F) : 0.0F;
  }

  std::vector<float> borders_;
  float border_mm_ = 0;
};

}  // namespace lamella
