// The matching cost of every pixel and label, as semi-global matching reads it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "lightfield/large_pages.h"

namespace lamella {

struct FreeVolumeBytes {
  std::size_t size = 0;
  void operator()(std::uint8_t* bytes) const {
    PixelAllocator<std::uint8_t>().deallocate(bytes, size);
  }
};
// Memory of a volume, not initialised.
using VolumeBytes = std::unique_ptr<std::uint8_t[], FreeVolumeBytes>;

// `size` bytes or more: `old`, or fresh ones where those are too few.
inline VolumeBytes AtLeast(std::size_t size, VolumeBytes old) {
  if (old && old.get_deleter().size >= size) return old;
  old.reset();
  return VolumeBytes(PixelAllocator<std::uint8_t>().allocate(size), FreeVolumeBytes{size});
}

// Memory that matching leaves for the next view: the system takes as long to give out fresh pages
// of such size as semi-global matching takes to fill them.
struct MatchMemory {
  VolumeBytes costs, paths;
};

// Labels of one pixel are neighbours in memory. Costs are 0..kMaxCost; the labels that pad a pixel
// to `stride` hold kMaxCost.
struct CostVolume {
  // With the largest jump penalty kMaxCost + kMaxPenalty = 255: path costs fit into 8 bits.
  static constexpr int kMaxCost = 191;
  static constexpr int kLabelBlock = 32;

  CostVolume(int width_px, int height_px, int num_labels, VolumeBytes memory = {})
      : width(width_px),
        height(height_px),
        labels(num_labels),
        stride((num_labels + kLabelBlock - 1) / kLabelBlock * kLabelBlock),
        costs(AtLeast(Bytes(), std::move(memory))) {}

  std::size_t Bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(stride);
  }
  std::uint8_t* At(int x, int y) { return costs.get() + Offset(x, y); }
  const std::uint8_t* At(int x, int y) const { return costs.get() + Offset(x, y); }

  int width = 0, height = 0, labels = 0, stride = 0;
  VolumeBytes costs;

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
