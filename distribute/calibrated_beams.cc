#include "distribute/calibrated_beams.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "distribute/accumulate_kernels.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr int kEnclosingStep = 64;     // rows and columns that stand for those between
constexpr double kEnclosingWidth = 3;  // of emitters, so that one more direction is enclosed

// Appends the beams of an emitter, or of its three sub-pixels.
void AddBeams(const CalibratedMap& map, const Display& display, int layer, int slot, int column,
              int row, RowOfBeams& beams) {
  const Layer& of = display.layers[Index(layer)];
  const int channels = EmitterColumns(display, of) / display.emitter_columns();
  const int k = map.slots_per_axis();
  for (int channel = 0; channel < channels; ++channel) {
    const auto beam = map.BeamOf(slot, channel, column, row);
    if (!beam) continue;
    const double offset = beam->z_mm - of.position_mm;
    beams.x.push_back({slot % k, channels * column + channel, 0, beam->beam.x, offset});
    beams.y.push_back({slot / k, row, 0, Downwards(beam->beam.y), offset});
  }
}

// Runs of `run` indices every few, and the last ones.
std::vector<int> Few(int count, int run) {
  std::vector<int> few;
  for (int i = 0; i < count; ++i) {
    if (i % kEnclosingStep < run || i >= count - run) few.push_back(i);
  }
  return few;
}

void Widen(std::vector<EmitterBeam>& beams) {
  for (EmitterBeam& beam : beams) beam.beam.emitter_width_mm *= kEnclosingWidth;
}

// Sum of the samples' light by the weights of both axes; nothing of what lies beyond the image.
Eigen::Array4f Gather(const Image<Light>& light, const NodeSamples& node, const Overlap& x,
                      const float* x_weights, const Overlap& y, const float* y_weights) {
  const int first_x = x.first_sample - node.first_x, first_y = y.first_sample - node.first_y;
  const int begin_x = std::max(0, -first_x),
            end_x = std::min(x.num_samples, light.width() - first_x);
  const int begin_y = std::max(0, -first_y),
            end_y = std::min(y.num_samples, light.height() - first_y);
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int j = begin_y; j < end_y; ++j) {
    const Light* row = light.row(first_y + j) + first_x;
    Eigen::Array4f of_row = Eigen::Array4f::Zero();
    for (int i = begin_x; i < end_x; ++i) {
      of_row += x_weights[i] * Eigen::Map<const Eigen::Array4f, Eigen::Aligned16>(&row[i].r);
    }
    sum += y_weights[j] * of_row;
  }
  return sum;
}

void AddNode(const NodeSamples& node, const Image<Light>& light, int node_y, const OwnOverlaps& row,
             Light* sums) {
  const std::vector<Overlap>& xs = row.x.nodes[Index(node.node_x)];
  const std::vector<Overlap>& ys = row.y.nodes[Index(node_y)];
  auto y = ys.begin();
  for (const Overlap& x : xs) {  // both by rising columns
    while (y != ys.end() && y->emitter < x.emitter) ++y;
    if (y == ys.end()) return;
    if (y->emitter != x.emitter) continue;
    Eigen::Map<Eigen::Array4f, Eigen::Aligned16>(&sums[x.emitter].r) += Gather(
        light, node, x, row.x.weights.data() + x.weights, *y, row.y.weights.data() + y->weights);
  }
}

}  // namespace

double PeriodPx(const Display& display, const Layer& layer) {
  return LatticePitchMm(display, layer) * SlotsPerAxis(layer) / display.emitter_pitch_mm(layer);
}

RowOfBeams BeamsOfRow(const CalibratedMap& map, const Display& display, int layer, int slot,
                      int row) {
  RowOfBeams beams;
  for (int column = 0; column < display.emitter_columns(); ++column) {
    AddBeams(map, display, layer, slot, column, row, beams);
  }
  return beams;
}

LayerBeams EnclosingBeamsOf(const CalibratedMap& map, const Display& display, int layer) {
  LayerBeams enclosing;
  enclosing.columns.resize(1);
  const int run = 1 + static_cast<int>(std::ceil(PeriodPx(display, display.layers[Index(layer)])));
  RowOfBeams rows, columns;  // of the first slot: others' openings are less than a period away
  for (const int row : Few(display.emitter_rows(), run)) {
    for (int column = 0; column < display.emitter_columns(); ++column) {
      AddBeams(map, display, layer, 0, column, row, rows);
    }
  }
  for (const int column : Few(display.emitter_columns(), run)) {
    for (int row = 0; row < display.emitter_rows(); ++row) {
      AddBeams(map, display, layer, 0, column, row, columns);
    }
  }
  enclosing.columns[0] = std::move(rows.x);
  enclosing.rows = std::move(columns.y);
  const Layer& of = display.layers[Index(layer)];
  if (std::holds_alternative<BarePanel>(of.optics)) return enclosing;  // all have one eye box
  Widen(enclosing.columns[0]);
  Widen(enclosing.rows);
  return enclosing;
}

void AccumulateOwn(std::span<const NodeSamples> nodes, int node_y, const LayerWeights& weights,
                   int layer, LayerSums& sums) {
  for (const NodeSamples& node : nodes) {
    Image<Light>& light = sums.overlaps.taken;
    if (light.width() != node.samples.width || light.height() != node.samples.height) {
      light = Image<Light>(node.samples.width, node.samples.height);
    }
    ParallelForEach(0, light.height(), [&](std::int64_t y) {
      const int row = static_cast<int>(y);
      TakeRow(node.samples.row(row), light.width(), weights, layer, 1, light.row(row));
    });
    ParallelForEach(0, static_cast<std::int64_t>(sums.overlaps.own.size()), [&](std::int64_t i) {
      const OwnOverlaps& row = sums.overlaps.own[static_cast<std::size_t>(i)];
      AddNode(node, light, node_y, row,
              sums.sums.slots[Index(row.slot)].row(row.row - sums.sums.first_row));
    });
  }
}

}  // namespace lamella
