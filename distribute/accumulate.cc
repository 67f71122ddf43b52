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
constexpr int kLeastBandRows = 32, kMostBandRows = 128;
constexpr int kBandsPerThread = 4;

int BandRows(std::span<const LayerSums> layers) {
  int rows = 0;
  for (const LayerSums& layer : layers) rows += layer.sums.slots.at(0).height();
  return std::clamp(rows / (kBandsPerThread * NumThreads()), kLeastBandRows, kMostBandRows);
}

// The overlaps along y of some emitter rows of a layer, by their first sample: so each row of
// samples is needed once.
struct Band {
  int layer = 0;
  std::vector<const Overlap*> rows;
  int first_sample() const { return rows.empty() ? 0 : rows[0]->first_sample; }
};

void AddBands(int layer, const LayerSums& of, int node_y, int band_rows, std::vector<Band>& bands) {
  const int rows = of.sums.slots.at(0).height();
  const std::size_t first = bands.size();
  bands.resize(first + Index((rows + band_rows - 1) / band_rows), Band{layer, {}});
  for (const Overlap& overlap : of.overlaps.y.nodes[Index(node_y)]) {
    const int band = (overlap.emitter - of.sums.first_row) / band_rows;
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

// Places that follow each other in a row of sums, with all that they take of a row of samples:
// `taps` each, from the sample firsts[i] of the row on with weights[taps * i ...].
struct Run {
  int slot = 0, place = 0;
  int taps = 0;
  std::vector<int> firsts;
  std::vector<float> weights;
  int count() const { return static_cast<int>(firsts.size()); }
};

// Of a node, whose rows of samples are `width` long. Taps that an overlap lacks weigh nothing.
std::vector<Run> RunsOf(const std::vector<Overlap>& overlaps, const float* weights, int first_x,
                        int width) {
  int taps = 1;
  for (const Overlap& overlap : overlaps) taps = std::max(taps, overlap.num_samples);
  std::vector<Run> runs;
  for (const Overlap& overlap : overlaps) {
    if (runs.empty() || runs.back().slot != overlap.slot ||
        runs.back().place + runs.back().count() != overlap.emitter) {
      runs.push_back({overlap.slot, overlap.emitter, taps, {}, {}});
    }
    Run& run = runs.back();
    const int first = overlap.first_sample - first_x;
    run.firsts.push_back(std::min(first, width - taps));
    run.weights.resize(run.weights.size() + Index(taps));
    std::copy_n(weights + overlap.weights, overlap.num_samples,
                run.weights.end() - taps + (first - run.firsts.back()));
  }
  return runs;
}

// Of a slot's places, those that any of some nodes add to, and those between; where their lights
// lie in a filtered row.
struct Extent {
  int first = std::numeric_limits<int>::max(), end = 0;
  int at = 0;
  int count() const { return std::max(end - first, 0); }
};

// A node's part in a band.
struct NodeInBand {
  const NodeSamples& samples;
  RowWindow taken;
};

// A family's columns, all nodes' parts together, and the rows of samples that were filtered to
// them.
class FamilyRows {
 public:
  FamilyRows(const AxisOverlaps& x, std::span<const NodeInBand> nodes, int slots, int most_rows)
      : extents_(Index(slots)) {
    for (const NodeInBand& node : nodes) {
      const std::vector<Overlap>& columns = x.nodes[Index(node.samples.node_x)];
      runs_.push_back(
          RunsOf(columns, x.weights.data(), node.samples.first_x, node.samples.samples.width));
      for (const Run& run : runs_.back()) {
        Extent& extent = extents_[Index(run.slot)];
        extent.first = std::min(extent.first, run.place);
        extent.end = std::max(extent.end, run.place + run.count());
      }
    }
    for (Extent& extent : extents_) {
      extent.at = width_;
      width_ += extent.count();
    }
    filtered_ = std::make_unique<RowWindow>(most_rows, width_);
  }

  // Rows of samples that all nodes have taken.
  void Filter(std::span<NodeInBand> nodes, const Overlap& rows) {
    filtered_->Fill(rows.first_sample, rows.num_samples, [&](int j, Light* out) {
      std::fill_n(out, width_, Light());
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Light* taken = nodes[n].taken.Row(j);
        for (const Run& run : runs_[n]) {
          const Extent& extent = extents_[Index(run.slot)];
          AddFiltered(taken, run.firsts, run.weights.data(), run.taps,
                      out + extent.at + (run.place - extent.first));
        }
      }
    });
  }

  void AddTo(const Overlap& row, const float* row_weights, EmitterSums& sums) {
    for (std::size_t slot = 0; slot < extents_.size(); ++slot) {
      const Extent& extent = extents_[slot];
      if (extent.count() == 0) continue;
      taps_.clear();
      for (int i = 0; i < row.num_samples; ++i) {
        taps_.push_back(filtered_->Row(row.first_sample + i) + extent.at);
      }
      Image<Light>& to = sums.slots[Index(sums.slots_per_axis * row.slot) + slot];
      AddRows(taps_.data(), row_weights + row.weights, row.num_samples, extent.count(),
              to.row(row.emitter - sums.first_row) + extent.first);
    }
  }

 private:
  std::vector<std::vector<Run>> runs_;  // by node
  std::vector<Extent> extents_;         // by slot along x
  int width_ = 0;
  std::unique_ptr<RowWindow> filtered_;
  std::vector<const Light*> taps_;
};

// Light of all nodes is added up along rows before it goes down columns: sums of emitters, too many
// for the cache, are then met once for each tap of a column and not for each node's.
void AddBand(const Band& band, std::span<const NodeSamples> nodes, const LayerWeights& weights,
             LayerSums& layer) {
  int most_rows = 1;
  for (const Overlap* row : band.rows) most_rows = std::max(most_rows, row->num_samples);
  std::vector<NodeInBand> in_band;
  in_band.reserve(nodes.size());
  const LayerOverlaps& overlaps = layer.overlaps;
  for (const NodeSamples& node : nodes) {
    const auto takes = [&](const AxisOverlaps& x) { return !x.nodes[Index(node.node_x)].empty(); };
    if (std::none_of(overlaps.x.begin(), overlaps.x.end(), takes)) continue;
    in_band.push_back({node, RowWindow(most_rows, node.samples.width)});
  }
  std::vector<std::unique_ptr<FamilyRows>> families(overlaps.x.size());
  std::vector<int> rows_left(families.size(), 0);  // where each row is a family, few live at a time
  for (const Overlap* row : band.rows) ++rows_left[Index(row->family)];
  for (const Overlap* row : band.rows) {
    for (auto& [node, taken] : in_band) {
      taken.Fill(row->first_sample, row->num_samples, [&, &node = node](int j, Light* out) {
        TakeRow(node.samples.row(j - node.first_y), node.samples.width, weights, band.layer, out);
      });
    }
    std::unique_ptr<FamilyRows>& family = families[Index(row->family)];
    if (!family) {
      family = std::make_unique<FamilyRows>(overlaps.x[Index(row->family)], in_band,
                                            layer.sums.slots_per_axis, most_rows);
    }
    family->Filter(in_band, *row);
    family->AddTo(*row, overlaps.y.weights.data(), layer.sums);
    if (--rows_left[Index(row->family)] == 0) family.reset();
  }
}

}  // namespace

void Accumulate(std::span<const NodeSamples> nodes, int node_y, const LayerWeights& weights,
                std::span<LayerSums> layers) {
  std::vector<Band> bands;
  const int band_rows = BandRows(layers);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const int layer = static_cast<int>(l);
    if (layers[l].overlaps.own.empty()) {
      AddBands(layer, layers[l], node_y, band_rows, bands);
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
