// Rows of a display's emitters that are in memory, where all are too many.
#pragma once

#include <functional>
#include <vector>

#include "distribute/distribute.h"
#include "lightfield/display.h"

namespace lamella {

struct RowRange {
  int first = 0, end = 0;

  int size() const { return end - first; }
  // Around both; an empty one adds nothing.
  RowRange With(const RowRange& other) const;
  friend bool operator==(const RowRange&, const RowRange&) = default;
};

// The rows [first_row, end_row) of a slot's emitters, as wide as the display.
using ReadEmitterRows = std::function<EmitterImage(int first_row, int end_row)>;

// A slot's emitters from the top on: rows that rise and are asked for once, by one thread at a
// time.
using OpenEmitters = std::function<ReadEmitterRows(int layer, int slot)>;
// Of images in memory, which it refers to.
OpenEmitters OpenImages(const LayerImages& images);

// All rows of a slot, or of all slots, read some at a time.
EmitterImage ReadWhole(const ReadEmitterRows& read, const Display& display);
LayerImages ReadWhole(const OpenEmitters& open, const Display& display);
// Rows of an image whose row 0 is the display's row `origin`.
void ReadRows(const ReadEmitterRows& read, const RowRange& rows, int origin, EmitterImage& image);
// What all emitters take, and the mean over the slots of layers that leak.
double BytesOfAll(const Display& display);

// Of every layer some rows of all slots.
struct EmitterStrip {
  const LayerImages* images = nullptr;
  std::vector<int> first_row;  // by layer: the display's row that is row 0 of its images
  // By layer, what closed modulators let through: the mean of its slots; empty where that is none.
  std::vector<EmitterImage> leaks;
};

// Refers to the images.
EmitterStrip StripOf(const LayerImages& images, std::vector<int> first_row, const Display& display);

// Whether a layer's closed modulators let light through.
bool Leaks(const Layer& layer);

}  // namespace lamella
