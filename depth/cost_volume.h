// The matching cost of every pixel and label, as semi-global matching reads it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace lamella {

// Labels of one pixel are neighbours in memory. Costs are 0..kMaxCost; the labels that pad a pixel
// to `stride` hold kMaxCost.
struct CostVolume {
  // With the largest jump penalty kMaxCost + kMaxPenalty = 255: path costs fit into 8 bits.
  static constexpr int kMaxCost = 191;
  static constexpr int kLabelBlock = 32;

  CostVolume(int width_px, int height_px, int num_labels)
      : width(width_px),
        height(height_px),
        labels(num_labels),
        stride((num_labels + kLabelBlock - 1) / kLabelBlock * kLabelBlock),
        costs(std::make_unique_for_overwrite<std::uint8_t[]>(Bytes())) {}

  std::size_t Bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(stride);
  }
  std::uint8_t* At(int x, int y) { return costs.get() + Offset(x, y); }
  const std::uint8_t* At(int x, int y) const { return costs.get() + Offset(x, y); }

  int width = 0, height = 0, labels = 0, stride = 0;
  std::unique_ptr<std::uint8_t[]> costs;

 private:
  std::size_t Offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(stride);
  }
};

// A label and a share of the step to the next one, in fixed point: label * kSubLabels + share.
using SubLabel = std::uint16_t;
constexpr int kSubLabels = 128;
constexpr int kMaxLabels = 65536 / kSubLabels - 2;

}  // namespace lamella
