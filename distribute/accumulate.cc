#include "distribute/accumulate.h"

#include <algorithm>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Emitter rows whose sums one task owns. More rows share more of the samples' rows, fewer keep
// those in the cache.
constexpr int kBandRows = 48;

inline void AddScaled(Light& sum, float weight, const Light& light) {
  sum.r += weight * light.r;
  sum.g += weight * light.g;
  sum.b += weight * light.b;
  sum.coverage += weight * light.coverage;
}

// out[i] = overlap i of the node along x, for one row of samples.
void FilterRow(const Light* row, int first_x, const std::vector<Overlap>& overlaps,
               const float* weights, Light* out) {
  for (const Overlap& overlap : overlaps) {
    const Light* sample = row + (overlap.first_sample - first_x);
    const float* weight = weights + overlap.weights;
    Light sum;
    for (int i = 0; i < overlap.num_samples; ++i) AddScaled(sum, weight[i], sample[i]);
    *out++ = sum;
  }
}

struct Band {
  std::vector<const Overlap*> rows;  // overlaps of the band's emitter rows along y
  int first_sample = 0, end_sample = 0;
};

std::vector<Band> BandsOf(const std::vector<Overlap>& overlaps, int emitter_rows) {
  std::vector<Band> bands(static_cast<std::size_t>((emitter_rows + kBandRows - 1) / kBandRows));
  for (const Overlap& overlap : overlaps) {
    Band& band = bands[static_cast<std::size_t>(overlap.emitter / kBandRows)];
    const int end = overlap.first_sample + overlap.num_samples;
    band.first_sample = band.rows.empty() ? overlap.first_sample
                                          : std::min(band.first_sample, overlap.first_sample);
    band.end_sample = band.rows.empty() ? end : std::max(band.end_sample, end);
    band.rows.push_back(&overlap);
  }
  return bands;
}

// Adds the weighted sum of filtered rows to one emitter row of every slot along x.
void AddRow(const Overlap& row, const float* weights, const Light* filtered, std::size_t stride,
            const std::vector<Overlap>& columns, Light* const* sums_of_slot) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    Light& sum = sums_of_slot[columns[i].slot][columns[i].emitter];
    const Light* light = filtered + i;
    for (int j = 0; j < row.num_samples; ++j, light += stride) AddScaled(sum, weights[j], *light);
  }
}

}  // namespace

void Accumulate(ImageSpan<const Light> samples, int first_x, int first_y, const AxisOverlaps& x,
                int node_x, const AxisOverlaps& y, int node_y, EmitterSums& sums) {
  const std::vector<Overlap>& columns = x.nodes[static_cast<std::size_t>(node_x)];
  const std::vector<Overlap>& rows = y.nodes[static_cast<std::size_t>(node_y)];
  const std::vector<Band> bands = BandsOf(rows, sums.slots.at(0).height());
  const std::size_t stride = columns.size();
  ParallelForEach(0, static_cast<std::int64_t>(bands.size()), [&](std::int64_t b) {
    const Band& band = bands[static_cast<std::size_t>(b)];
    std::vector<Light> filtered(stride *
                                static_cast<std::size_t>(band.end_sample - band.first_sample));
    for (int j = band.first_sample; j < band.end_sample; ++j) {
      FilterRow(samples.row(j - first_y), first_x, columns, x.weights.data(),
                filtered.data() + stride * static_cast<std::size_t>(j - band.first_sample));
    }
    std::vector<Light*> sums_of_slot(static_cast<std::size_t>(sums.slots_per_axis));
    for (const Overlap* row : band.rows) {
      for (int slot_x = 0; slot_x < sums.slots_per_axis; ++slot_x) {
        const int slot = sums.slots_per_axis * row->slot + slot_x;
        sums_of_slot[static_cast<std::size_t>(slot_x)] =
            sums.slots[static_cast<std::size_t>(slot)].row(row->emitter);
      }
      AddRow(*row, y.weights.data() + row->weights,
             filtered.data() +
                 stride * static_cast<std::size_t>(row->first_sample - band.first_sample),
             stride, columns, sums_of_slot.data());
    }
  });
}

}  // namespace lamella
