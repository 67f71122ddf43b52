#include "distribute/seen_rays.h"

#include <cmath>
#include <cstddef>

namespace lamella {

bool PassesWithin(const AxisBeam& beam, double element_mm, double size_mm) {
  return std::abs(beam.At(-element_mm)) <= size_mm / 2;
}

SeenCounter::SeenCounter(const LayerBeams& beams, double layer_mm, int slot, int slots_per_axis,
                         const PictureSize& picture)
    : beams_(beams),
      layer_mm_(layer_mm),
      slot_y_(slot / slots_per_axis),
      height_mm_(picture.height_mm),
      columns_(beams.columns.size()) {
  for (std::size_t family = 0; family < columns_.size(); ++family) {
    for (const EmitterBeam& column : beams.columns[family]) {
      if (column.slot != slot % slots_per_axis) continue;
      if (!PassesWithin(column.beam, layer_mm, picture.width_mm)) continue;
      columns_[family].push_back(column.emitter);
    }
  }
}

void SeenCounter::Add(int first_row, const Image<float>& coverage, SeenRays& count) const {
  for (const EmitterBeam& row : beams_.rows) {
    const int y = row.emitter - first_row;
    if (row.slot != slot_y_ || y < 0 || y >= coverage.height()) continue;
    if (!PassesWithin(row.beam, layer_mm_, height_mm_)) continue;
    const float* of_row = coverage.row(y);
    const std::vector<int>& columns = columns_[static_cast<std::size_t>(row.family)];
    for (const int column : columns) count.seen += static_cast<double>(of_row[column]);
    count.rays += static_cast<double>(columns.size());
  }
}

void CountOwn(const Ways& ways, int first_row, const Image<float>& coverage, SeenRays& all,
              SeenRays& in_picture) {
  for (int y = 0; y < coverage.height(); ++y) {
    const int strip_row = first_row + y;
    const std::vector<Way>& row = ways[static_cast<std::size_t>(strip_row)];
    for (std::size_t column = 0; column < row.size(); ++column) {
      if (row[column] == Way::kDark) continue;
      const SeenRays ray{1, static_cast<double>(coverage.row(y)[column])};
      all.Add(ray);
      if (row[column] == Way::kThroughPicture) in_picture.Add(ray);
    }
  }
}

}  // namespace lamella
