#include "pipeline/emitter_rows.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "distribute/strips.h"

namespace lamella {
namespace {

// The mean of slots, a block of rows at a time.
class Block {
 public:
  Block(std::vector<ReadEmitterRows> slots, int rows) : slots_(std::move(slots)), rows_(rows) {}

  const Rgb* Row(int y) {
    if (y < first_ || y >= first_ + mean_.height()) Read(y / kBlockRows * kBlockRows);
    return mean_.row(y - first_);
  }

 private:
  void Read(int first) {
    const int end = std::min(first + kBlockRows, rows_);
    const float weight = 1.0F / static_cast<float>(slots_.size());
    Image<Rgb> mean;
    for (const ReadEmitterRows& read : slots_) {
      const EmitterImage slot = read(first, end);
      if (mean.empty()) mean = Image<Rgb>(slot.color.width(), end - first);
      for (std::size_t i = 0; i < mean.size(); ++i) mean.data()[i] += weight * slot.color.data()[i];
    }
    first_ = first;
    mean_ = std::move(mean);
  }

  const std::vector<ReadEmitterRows> slots_;
  const int rows_;
  int first_ = 0;
  Image<Rgb> mean_;
};

RowOf RowsOf(std::vector<ReadEmitterRows> slots, const Display& display) {
  const auto block = std::make_shared<Block>(std::move(slots), display.emitter_rows());
  return [block](int y, Rgb*) { return block->Row(y); };
}

}  // namespace

RowOf LightRows(const OpenEmitters& open, const Display& display, int layer, int slot) {
  return RowsOf({open(layer, slot)}, display);
}

RowOf MeanRows(const OpenEmitters& open, const Display& display, int layer) {
  const int k = SlotsPerAxis(display.layers[static_cast<std::size_t>(layer)]);
  std::vector<ReadEmitterRows> slots;
  for (int slot = 0; slot < k * k; ++slot) slots.push_back(open(layer, slot));
  return RowsOf(std::move(slots), display);
}

}  // namespace lamella
