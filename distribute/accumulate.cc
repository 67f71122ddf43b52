#include "distribute/accumulate.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "distribute/accumulate_kernels.h"
#include "distribute/calibrated_beams.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Emitter rows whose sums one task owns. More rows share more of the samples' rows, fewer keep
// more threads busy.
constexpr int kBandRows = 32;

// The overlaps along y of some emitter rows of a layer, by their first sample: so each row of
// samples is needed once.
struct Band {
  int layer = 0;
  std::vector<const Overlap*> rows;
  int first_sample() const { return rows.empty() ? 0 : rows[0]->first_sample; }
};

void AddBands(int layer, const LayerSums& of, int node_y, std::vector<Band>& bands) {
  const int rows = of.sums.slots.at(0).height();
  const std::size_t first = bands.size();
  bands.resize(first + Index((rows + kBandRows - 1) / kBandRows), Band{layer, {}});
  for (const Overlap& overlap : of.overlaps.y.nodes[Index(node_y)]) {
    const int band = (overlap.emitter - of.sums.first_row) / kBandRows;
    bands[first + Index(band)].rows.push_back(&overlap);
  }
  for (std::size_t i = first; i < bands.size(); ++i) {
    std::stable_sort(
        bands[i].rows.begin(), bands[i].rows.end(),
        [](const Overlap* a, const Overlap* b) { return a->first_sample < b->first_sample; });
  }
}

// Room for lights, kept by each thread: bands are many and short-lived, and fresh memory is slow.
class Room {
 public:
  explicit Room(std::size_t lights) {
    if (!Kept().empty()) {
      lights_ = std::move(Kept().back());
      Kept().pop_back();
    }
    if (lights_.size() < lights) lights_.resize(lights);
  }
  ~Room() {
    if (!lights_.empty()) Kept().push_back(std::move(lights_));
  }
  Room(Room&&) = default;
  Light* data() { return lights_.data(); }

 private:
  static std::vector<std::vector<Light>>& Kept() {
    thread_local std::vector<std::vector<Light>> kept;
    return kept;
  }
  std::vector<Light> lights_;
};

// Keeps the last `most` rows that were made; rows are asked for in rising order.
class RowWindow {
 public:
  RowWindow(int most, int width) : most_(most), width_(Index(width)), room_(Index(most) * width_) {}

  // Calls make(row, out) for those of the rows [first, first + count) that were not made before.
  template <class Make>
  void Fill(int first, int count, const Make& make) {
    next_ = std::max(next_, first);
    for (; next_ < first + count; ++next_) make(next_, Row(next_));
  }
  // Indices of samples may be negative.
  Light* Row(int row) { return room_.data() + Index((row % most_ + most_) % most_) * width_; }

 private:
  int most_;
  std::size_t width_;
  Room room_;
  int next_ = std::numeric_limits<int>::min();
};

// Places that follow each other in a row of sums, and so do their overlaps.
struct Run {
  int slot = 0, place = 0;
  int first = 0, count = 0;  // of the overlaps
};

std::vector<Run> RunsOf(const std::vector<Overlap>& overlaps) {
  std::vector<Run> runs;
  for (int i = 0; i < static_cast<int>(overlaps.size()); ++i) {
    const Overlap& overlap = overlaps[Index(i)];
    if (runs.empty() || runs.back().slot != overlap.slot ||
        runs.back().place + runs.back().count != overlap.emitter) {
      runs.push_back({overlap.slot, overlap.emitter, i, 0});
    }
    ++runs.back().count;
  }
  return runs;
}

// The columns of a family at a node, and the rows of samples that were filtered to them.
struct FamilyRows {
  FamilyRows(const AxisOverlaps& x, int node_x, int most_rows)
      : columns(x.nodes[Index(node_x)]),
        weights(x.weights.data()),
        runs(RunsOf(columns)),
        filtered(most_rows, static_cast<int>(columns.size())) {}
  const std::vector<Overlap>& columns;
  const float* weights;
  std::vector<Run> runs;
  RowWindow filtered;
};

void AddRun(const Run& run, const Overlap& row, const float* row_weights, FamilyRows& family,
            std::vector<const Light*>& taps, EmitterSums& sums) {
  taps.clear();
  for (int i = 0; i < row.num_samples; ++i) {
    taps.push_back(family.filtered.Row(row.first_sample + i) + run.first);
  }
  Image<Light>& slot = sums.slots[Index(sums.slots_per_axis * row.slot + run.slot)];
  AddRows(taps.data(), row_weights + row.weights, row.num_samples, run.count,
          slot.row(row.emitter - sums.first_row) + run.place);
}

// A node's part in a band.
class NodeInBand {
 public:
  NodeInBand(const NodeSamples& node, const LayerWeights& weights, int layer,
             const LayerOverlaps& overlaps, int most_rows)
      : node_(node),
        weights_(weights),
        layer_(layer),
        overlaps_(overlaps),
        most_rows_(most_rows),
        taken_(most_rows, node.samples.width),
        families_(overlaps.x.size()) {}

  void Add(const Overlap& row, EmitterSums& sums) {
    const AxisOverlaps& x = overlaps_.x[Index(row.family)];
    if (x.nodes[Index(node_.node_x)].empty()) return;
    std::unique_ptr<FamilyRows>& family = families_[Index(row.family)];
    if (!family) family = std::make_unique<FamilyRows>(x, node_.node_x, most_rows_);
    taken_.Fill(row.first_sample, row.num_samples, [&](int j, Light* out) {
      TakeRow(node_.samples.row(j - node_.first_y), node_.samples.width, weights_, layer_, out);
    });
    family->filtered.Fill(row.first_sample, row.num_samples, [&](int j, Light* out) {
      FilterRow(taken_.Row(j), node_.first_x, family->columns, family->weights, out);
    });
    for (const Run& run : family->runs) {
      AddRun(run, row, overlaps_.y.weights.data(), *family, taps_, sums);
    }
  }

 private:
  const NodeSamples& node_;
  const LayerWeights& weights_;
  const int layer_;
  const LayerOverlaps& overlaps_;
  const int most_rows_;
  RowWindow taken_;
  std::vector<std::unique_ptr<FamilyRows>> families_;
  std::vector<const Light*> taps_;
};

void AddBand(const Band& band, std::span<const NodeSamples> nodes, const LayerWeights& weights,
             LayerSums& layer) {
  int most_rows = 1;
  for (const Overlap* row : band.rows) most_rows = std::max(most_rows, row->num_samples);
  std::vector<NodeInBand> in_band;
  in_band.reserve(nodes.size());
  for (const NodeSamples& node : nodes) {
    in_band.emplace_back(node, weights, band.layer, layer.overlaps, most_rows);
  }
  // An emitter gets what it gets of all nodes while it is in the cache.
  for (const Overlap* row : band.rows) {
    for (NodeInBand& node : in_band) node.Add(*row, layer.sums);
  }
}

}  // namespace

void Accumulate(std::span<const NodeSamples> nodes, int node_y, const LayerWeights& weights,
                std::span<LayerSums> layers) {
  std::vector<Band> bands;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const int layer = static_cast<int>(l);
    if (layers[l].overlaps.own.empty()) {
      AddBands(layer, layers[l], node_y, bands);
    } else {
      AccumulateOwn(nodes, node_y, weights, layer, layers[l]);
    }
  }
  // Bands of the same samples after each other.
  std::stable_sort(bands.begin(), bands.end(), [](const Band& a, const Band& b) {
    return a.first_sample() < b.first_sample();
  });
  ParallelForEach(0, static_cast<std::int64_t>(bands.size()), [&](std::int64_t i) {
    const Band& band = bands[static_cast<std::size_t>(i)];
    AddBand(band, nodes, weights, layers[Index(band.layer)]);
  });
}

}  // namespace lamella
