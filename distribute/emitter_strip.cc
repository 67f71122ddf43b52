#include "distribute/emitter_strip.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>

#include "distribute/strips.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// The mean of a layer's emitters over its slots.
EmitterImage SlotMean(const std::vector<EmitterImage>& slots) {
  const int width = slots[0].color.width(), height = slots[0].color.height();
  EmitterImage mean{Image<Rgb>(width, height), Image<float>(width, height)};
  const float share = 1 / static_cast<float>(slots.size());
  ParallelFor(0, height, 16, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      for (const EmitterImage& slot : slots) {
        for (int x = 0; x < width; ++x) {
          mean.color(x, y) += share * slot.color(x, y);
          mean.coverage(x, y) += share * slot.coverage(x, y);
        }
      }
    }
  });
  return mean;
}

}  // namespace

OpenEmitters OpenImages(const LayerImages& images) {
  return [&images](int layer, int slot) -> ReadEmitterRows {
    const EmitterImage& all =
        images.slots[static_cast<std::size_t>(layer)][static_cast<std::size_t>(slot)];
    return [&all](int first_row, int end_row) {
      const int columns = all.color.width(), rows = end_row - first_row;
      EmitterImage image{Image<Rgb>(columns, rows), Image<float>(columns, rows)};
      std::copy_n(all.color.row(first_row), image.color.size(), image.color.data());
      std::copy_n(all.coverage.row(first_row), image.coverage.size(), image.coverage.data());
      return image;
    };
  };
}

void ReadRows(const ReadEmitterRows& read, const RowRange& rows, int origin, EmitterImage& image) {
  for (int first = rows.first; first < rows.end; first += kBlockRows) {
    const EmitterImage block = read(first, std::min(first + kBlockRows, rows.end));
    std::copy_n(block.color.data(), block.color.size(), image.color.row(first - origin));
    std::copy_n(block.coverage.data(), block.coverage.size(), image.coverage.row(first - origin));
  }
}

EmitterImage ReadWhole(const ReadEmitterRows& read, const Display& display) {
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  EmitterImage whole{Image<Rgb>(columns, rows), Image<float>(columns, rows)};
  ReadRows(read, {0, rows}, 0, whole);
  return whole;
}

LayerImages ReadWhole(const OpenEmitters& open, const Display& display) {
  LayerImages images;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const int k = SlotsPerAxis(display.layers[l]);
    images.slots.emplace_back(static_cast<std::size_t>(k * k));
    ParallelForEach(0, k * k, [&](std::int64_t slot) {
      images.slots[l][static_cast<std::size_t>(slot)] =
          ReadWhole(open(static_cast<int>(l), static_cast<int>(slot)), display);
    });
  }
  return images;
}

double BytesOfAll(const Display& display) {
  double slots = 0;
  for (const Layer& layer : display.layers) {
    const double k = SlotsPerAxis(layer);
    slots += k * k + (Leaks(layer) ? 1 : 0);
  }
  return slots * display.emitter_columns() * display.emitter_rows() * (sizeof(Rgb) + sizeof(float));
}

RowRange RowRange::With(const RowRange& other) const {
  if (size() <= 0) return other;
  if (other.size() <= 0) return *this;
  return {std::min(first, other.first), std::max(end, other.end)};
}

bool Leaks(const Layer& layer) {
  const auto* barrier = std::get_if<Barrier>(&layer.optics);
  return barrier != nullptr && std::isfinite(barrier->contrast);
}

EmitterStrip StripOf(const LayerImages& images, std::vector<int> first_row,
                     const Display& display) {
  EmitterStrip strip{&images, std::move(first_row),
                     std::vector<EmitterImage>(display.layers.size())};
  for (std::size_t l = 0; l < strip.leaks.size(); ++l) {
    if (Leaks(display.layers[l])) strip.leaks[l] = SlotMean(images.slots[l]);
  }
  return strip;
}

}  // namespace lamella
