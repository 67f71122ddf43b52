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

// Layers that take of a row of samples in one go: it comes from far, so it is read once for both.
constexpr std::size_t kLayersTogether = 2;
// A task owns the sums of the emitters of at most so many rows of samples, but for many rows, which
// are as many tasks for each thread. What emitters at a border reach beyond it is taken twice.
constexpr int kBandRows = 32, kBandsPerThread = 4;

// A row of emitters of layer first_layer + layer of a band, and what it takes along y.
struct BandRow {
  int layer = 0;
  const Overlap* overlap = nullptr;
};

// Rows of emitters of some layers that follow each other, by their first sample: so each row of
// samples is needed once.
struct Band {
  std::span<LayerSums> layers;
  int first_layer = 0;
  std::vector<BandRow> rows;  // never none
  int first_sample() const { return rows.front().overlap->first_sample; }
};

int NumBands(int sample_rows) {
  const int threads = NumThreads();
  const int most = kBandsPerThread * threads;
  const int rounds = (sample_rows + kBandRows * threads - 1) / (kBandRows * threads);
  return std::clamp(rounds * threads, 1, most);
}

void AddBands(std::span<LayerSums> layers, int first_layer, int node_y, std::vector<Band>& bands) {
  std::vector<BandRow> rows;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    if (!layers[l].overlaps.own.empty()) continue;
    for (const Overlap& overlap : layers[l].overlaps.y.nodes[Index(node_y)]) {
      rows.push_back({static_cast<int>(l), &overlap});
    }
  }
  if (rows.empty()) return;
  const auto first_sample = [](const BandRow& row) { return row.overlap->first_sample; };
  std::stable_sort(rows.begin(), rows.end(), [&](const BandRow& a, const BandRow& b) {
    return first_sample(a) < first_sample(b);
  });
  const int first = first_sample(rows.front()), count = first_sample(rows.back()) + 1 - first;
  const int num_bands = NumBands(count);
  auto from = rows.begin();
  for (int i = 1; i <= num_bands; ++i) {
    const int end = first + static_cast<int>(std::int64_t{count} * i / num_bands);
    const auto to = std::find_if(from, rows.end(),
                                 [&](const BandRow& row) { return first_sample(row) >= end; });
    if (to != from) bands.push_back({layers, first_layer, {from, to}});
    from = to;
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
    if (lights_.size() < lights) {
      lights_ = {};  // before there is another
      lights_ = std::vector<Light>(lights);
    }
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

// A node, and what each of the band's layers takes of its rows of samples, beside each other.
struct NodeInBand {
  const NodeSamples& samples;
  RowWindow taken;
};

bool TakesAny(const LayerOverlaps& overlaps, int node_x) {
  return std::any_of(overlaps.x.begin(), overlaps.x.end(), [&](const AxisOverlaps& family) {
    return !family.nodes[Index(node_x)].empty();
  });
}

// A family's columns, the parts of some nodes together, and the rows of samples that were filtered
// to them.
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

  // Rows of samples of which a layer has taken its part.
  void Filter(std::span<NodeInBand> nodes, int layer, const Overlap& rows) {
    filtered_->Fill(rows.first_sample, rows.num_samples, [&](int j, Light* out) {
      std::fill_n(out, width_, Light());
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Light* taken = nodes[n].taken.Row(j) + layer * nodes[n].samples.samples.width;
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

// Some nodes of a band. Their light is added up along rows before it goes down columns: sums of
// emitters, too many for the cache, are then met once for each tap of a column and not for each
// node's.
class NodeGroup {
 public:
  NodeGroup(std::span<const NodeSamples> nodes, std::span<LayerSums> layers, int most_rows)
      : most_rows_(most_rows) {
    nodes_.reserve(nodes.size());
    for (const LayerSums& layer : layers) families_.emplace_back(layer.overlaps.x.size());
    for (const NodeSamples& node : nodes) {
      if (std::none_of(layers.begin(), layers.end(), [&](const LayerSums& layer) {
            return TakesAny(layer.overlaps, node.node_x);
          })) {
        continue;
      }
      const int layers_width = node.samples.width * static_cast<int>(layers.size());
      nodes_.push_back({node, RowWindow(most_rows, layers_width)});
    }
  }

  // Adds to a row of emitters of a layer.
  void Add(const BandRow& row, const LayerWeights& weights, int first_layer, LayerSums& layer) {
    const Overlap& overlap = *row.overlap;
    const int layers = static_cast<int>(families_.size());
    for (auto& [node, taken] : nodes_) {
      taken.Fill(overlap.first_sample, overlap.num_samples, [&, &node = node](int j, Light* out) {
        TakeRow(node.samples.row(j - node.first_y), node.samples.width, weights, first_layer,
                layers, out);
      });
    }
    std::unique_ptr<FamilyRows>& family = families_[Index(row.layer)][Index(overlap.family)];
    if (!family) {
      family = std::make_unique<FamilyRows>(layer.overlaps.x[Index(overlap.family)], nodes_,
                                            layer.sums.slots_per_axis, most_rows_);
    }
    family->Filter(nodes_, row.layer, overlap);
    family->AddTo(overlap, layer.overlaps.y.weights.data(), layer.sums);
  }

  void Drop(const BandRow& row) { families_[Index(row.layer)][Index(row.overlap->family)].reset(); }

 private:
  int most_rows_;
  std::vector<NodeInBand> nodes_;
  std::vector<std::vector<std::unique_ptr<FamilyRows>>> families_;  // by layer and family
};

void AddBand(const Band& band, std::span<const NodeSamples> nodes, const LayerWeights& weights) {
  int most_rows = 1;
  std::vector<std::vector<int>> rows_left;  // where each row is a family, few live at a time
  for (const LayerSums& layer : band.layers) rows_left.emplace_back(layer.overlaps.x.size());
  for (const BandRow& row : band.rows) {
    most_rows = std::max(most_rows, row.overlap->num_samples);
    ++rows_left[Index(row.layer)][Index(row.overlap->family)];
  }
  std::vector<NodeGroup> groups;
  for (auto from = nodes.begin(); from != nodes.end();) {
    const int group = from->node_x / kNodesTogether;
    const auto to = std::find_if(from, nodes.end(), [&](const NodeSamples& node) {
      return node.node_x / kNodesTogether != group;
    });
    groups.emplace_back(std::span(from, to), band.layers, most_rows);
    from = to;
  }
  for (const BandRow& row : band.rows) {
    const bool last = --rows_left[Index(row.layer)][Index(row.overlap->family)] == 0;
    for (NodeGroup& group : groups) {
      group.Add(row, weights, band.first_layer, band.layers[Index(row.layer)]);
      if (last) group.Drop(row);
    }
  }
}

}  // namespace

void Accumulate(std::span<const NodeSamples> nodes, int node_y, const LayerWeights& weights,
                std::span<LayerSums> layers) {
  std::vector<Band> bands;
  for (std::size_t l = 0; l < layers.size(); l += kLayersTogether) {
    AddBands(layers.subspan(l, std::min(kLayersTogether, layers.size() - l)), static_cast<int>(l),
             node_y, bands);
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    if (layers[l].overlaps.own.empty()) continue;
    AccumulateOwn(nodes, node_y, weights, static_cast<int>(l), layers[l]);
  }
  // Bands of the same samples after each other.
  std::stable_sort(bands.begin(), bands.end(), [](const Band& a, const Band& b) {
    return a.first_sample() < b.first_sample();
  });
  ParallelForEach(0, static_cast<std::int64_t>(bands.size()), [&](std::int64_t i) {
    AddBand(bands[static_cast<std::size_t>(i)], nodes, weights);
  });
}

}  // namespace lamella
