#include "distribute/accumulate.h"

#include <algorithm>
#include <cmath>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Emitter rows whose sums one task owns. More rows share more of the samples' rows, fewer keep
// those in the cache.
constexpr int kBandRows = 48;

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

inline void AddScaled(Light& sum, float weight, const Light& light) {
  sum.r += weight * light.r;
  sum.g += weight * light.g;
  sum.b += weight * light.b;
  sum.coverage += weight * light.coverage;
}

// What a layer shows of a row of samples.
void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int layer,
             Light* out) {
  for (int i = 0; i < count; ++i) {
    const RaySample& sample = samples[i];
    const float light = sample.color.r + sample.color.g + sample.color.b;
    if (!(sample.coverage > 0 && std::isfinite(light))) {
      out[i] = Light();
      continue;
    }
    const float scale = weights.Weight(layer, sample.z) * sample.coverage;
    out[i] = {scale * sample.color.r, scale * sample.color.g, scale * sample.color.b,
              sample.coverage};
  }
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

// The overlaps along y of a band's emitter rows that have one family of columns, and the rows of
// samples that they need, filtered along x.
struct BandFamily {
  const std::vector<Overlap>* columns = nullptr;
  const float* weights = nullptr;  // of the columns
  std::vector<const Overlap*> rows;
  int first_sample = 0, end_sample = 0;
  std::vector<Light> filtered;

  std::size_t stride() const { return columns->size(); }
  Light* Filtered(int sample) { return filtered.data() + stride() * Index(sample - first_sample); }
};

struct Band {
  std::vector<BandFamily> families;
  int first_sample = 0, end_sample = 0;
};

std::vector<Band> BandsOf(const LayerOverlaps& overlaps, int node_x, int node_y,
                          const EmitterSums& sums) {
  const int rows = sums.slots.at(0).height();
  std::vector<Band> bands(Index((rows + kBandRows - 1) / kBandRows));
  std::vector<std::vector<int>> place(bands.size(), std::vector<int>(overlaps.x.size(), -1));
  const auto widen = [](auto& range, const Overlap& overlap, bool is_new) {
    const int end = overlap.first_sample + overlap.num_samples;
    range.first_sample =
        is_new ? overlap.first_sample : std::min(range.first_sample, overlap.first_sample);
    range.end_sample = is_new ? end : std::max(range.end_sample, end);
  };
  for (const Overlap& overlap : overlaps.y.nodes[Index(node_y)]) {
    const AxisOverlaps& x = overlaps.x[Index(overlap.family)];
    if (x.nodes[Index(node_x)].empty()) continue;
    const std::size_t b = Index((overlap.emitter - sums.first_row) / kBandRows);
    Band& band = bands[b];
    int& family = place[b][Index(overlap.family)];
    widen(band, overlap, band.families.empty());
    if (family < 0) {
      family = static_cast<int>(band.families.size());
      band.families.push_back({&x.nodes[Index(node_x)], x.weights.data(), {}, 0, 0, {}});
    }
    BandFamily& rows_of = band.families[Index(family)];
    widen(rows_of, overlap, rows_of.rows.empty());
    rows_of.rows.push_back(&overlap);
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

void AddFamily(BandFamily& family, const float* row_weights, EmitterSums& sums) {
  std::vector<Light*> sums_of_slot(Index(sums.slots_per_axis));
  for (const Overlap* row : family.rows) {
    for (int slot_x = 0; slot_x < sums.slots_per_axis; ++slot_x) {
      Image<Light>& slot = sums.slots[Index(sums.slots_per_axis * row->slot + slot_x)];
      sums_of_slot[Index(slot_x)] = slot.row(row->emitter - sums.first_row);
    }
    AddRow(*row, row_weights + row->weights, family.Filtered(row->first_sample), family.stride(),
           *family.columns, sums_of_slot.data());
  }
}

}  // namespace

void Accumulate(const NodeSamples& node, const LayerWeights& weights, int layer,
                const LayerOverlaps& overlaps, EmitterSums& sums) {
  std::vector<Band> bands = BandsOf(overlaps, node.node_x, node.node_y, sums);
  ParallelForEach(0, static_cast<std::int64_t>(bands.size()), [&](std::int64_t b) {
    Band& band = bands[static_cast<std::size_t>(b)];
    for (BandFamily& family : band.families) {
      family.filtered.resize(family.stride() * Index(family.end_sample - family.first_sample));
    }
    std::vector<Light> taken(Index(node.samples.width));
    for (int j = band.first_sample; j < band.end_sample; ++j) {
      TakeRow(node.samples.row(j - node.first_y), node.samples.width, weights, layer, taken.data());
      for (BandFamily& family : band.families) {
        if (j < family.first_sample || j >= family.end_sample) continue;
        FilterRow(taken.data(), node.first_x, *family.columns, family.weights, family.Filtered(j));
      }
    }
    for (BandFamily& family : band.families) {
      AddFamily(family, overlaps.y.weights.data(), sums);
      family.filtered = {};
    }
  });
}

}  // namespace lamella
