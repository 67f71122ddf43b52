#include "distribute/nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "distribute/depth_blur.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

AimRange AllAims(const Display& display, const std::vector<LayerBeams>& beams, bool rows,
                 const AimPlane& aim, Kernel kernel) {
  AimRange all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const auto add = [&](std::size_t layer, const std::vector<EmitterBeam>& some) {
    const AimRange range = AimsOf(some, display.layers[layer].position_mm, aim, kernel);
    all.min = std::min(all.min, range.min);
    all.max = std::max(all.max, range.max);
  };
  for (std::size_t layer = 0; layer < beams.size(); ++layer) {
    if (rows) add(layer, beams[layer].rows);
    if (rows) continue;
    for (const auto& family : beams[layer].columns) add(layer, family);
  }
  return all;
}

// Nodes every `step` that cover the range, one of them in the middle of an emitter's fan of aims
// where its number of directions is even as well as where it is odd.
NodeAxis CoverRange(const AimRange& range, double step, bool even) {
  if (!(range.min <= range.max)) return {0, step, 0};  // no emitter is lit
  constexpr double kMostNodes = 1 << 16;
  if (!((range.max - range.min) / step <= kMostNodes)) {
    throw UsageError(
        "layers", fmt::format("ask for {:.2g} directions per axis", (range.max - range.min) / step),
        "give bare panels a wider eye_box_mm or fewer views");
  }
  const double offset = even ? 0.5 : 0.0;
  const double first = std::floor(range.min / step - offset + 0.5);
  const double last = std::floor(range.max / step - offset + 0.5);
  return {(first + offset) * step, step, static_cast<int>(last - first) + 1};
}

// Of the layer that tells directions apart most finely.
double StepOfAims(const Display& display) {
  double step = std::numeric_limits<double>::infinity();
  for (const Layer& layer : display.layers) {
    step = std::min(step, AimStep(display, layer));
  }
  return step;
}

void AddRanges(const AxisOverlaps& overlaps, std::vector<SampleRange>& ranges) {
  for (int node = 0; node < static_cast<int>(ranges.size()); ++node) {
    const SampleRange range = SamplesOf({&overlaps}, node);
    SampleRange& all = ranges[Index(node)];
    if (range.size() == 0) continue;
    if (all.size() == 0) all = range;
    all = {std::min(all.first, range.first), std::max(all.end, range.end)};
  }
}

// Where within their cells a node's aim and its samples lie, per axis in [-1/2, 1/2).
struct Scatter {
  double aim_x = 0, aim_y = 0, sample_x = 0, sample_y = 0;
};

Scatter ScatterOf(const NodeLattice& nodes, int node_x, int node_y) {
  if (!nodes.scatter) return {};
  constexpr double kRoot = 1.1673039782614187;
  const double n = node_y * static_cast<double>(nodes.x.count) + node_x + 1;
  double step = 1;
  const auto next = [&] {
    step /= kRoot;
    const double point = n * step;
    return point - std::floor(point) - 0.5;
  };
  Scatter scatter;
  scatter.aim_x = next();
  scatter.aim_y = next();
  scatter.sample_x = next();
  scatter.sample_y = next();
  return scatter;
}

// Beams and the nodes' rays that stand for them cross in the layer, or in the plane that is
// blurred.
AxisOverlaps OverlapsAlong(const NodeLattice& nodes, const NodeAxis& axis,
                           const SampleAxis& samples, std::span<const EmitterBeam> beams,
                           double layer_mm, Kernel kernel, int plane) {
  if (nodes.planes_mm.empty()) {
    return OverlapsOf(beams, layer_mm, nodes.aim, layer_mm, axis, samples, kernel);
  }
  return BlurOverlapsOf(beams, layer_mm, nodes.aim, nodes.planes_mm[Index(plane)], axis, samples,
                        kernel);
}

}  // namespace

AxisOverlaps OverlapsAlongX(const NodeLattice& nodes, std::span<const EmitterBeam> columns,
                            double layer_mm, Kernel kernel, int plane) {
  return OverlapsAlong(nodes, nodes.x, nodes.sample_x, columns, layer_mm, kernel, plane);
}

AxisOverlaps OverlapsAlongY(const NodeLattice& nodes, std::span<const EmitterBeam> rows,
                            double layer_mm, Kernel kernel, int plane) {
  return OverlapsAlong(nodes, nodes.y, nodes.sample_y, rows, layer_mm, kernel, plane);
}

SampleRange SamplesOf(const std::vector<const AxisOverlaps*>& axes, int node) {
  SampleRange range{std::numeric_limits<int>::max(), std::numeric_limits<int>::min()};
  for (const AxisOverlaps* axis : axes) {
    for (const Overlap& overlap : axis->nodes[Index(node)]) {
      range.first = std::min(range.first, overlap.first_sample);
      range.end = std::max(range.end, overlap.first_sample + overlap.num_samples);
    }
  }
  return range.first < range.end ? range : SampleRange{};
}

NodeLattice NodesFor(const Display& display, const std::vector<LayerBeams>& beams,
                     int nodes_per_step, int samples_per_pixel, Kernel kernel,
                     const std::vector<double>& planes_mm) {
  NodeLattice nodes;
  nodes.planes_mm = planes_mm;
  nodes.aim = {display.shear, display.viewing_distance_mm};
  const double step = StepOfAims(display) / nodes_per_step;
  const Layer& first = display.layers[0];
  // The blur takes the one node that a beam's centre is nearest to: a bare panel's, the middle.
  const auto* bare = std::get_if<BarePanel>(&first.optics);
  const int eyes = bare == nullptr ? DirectionsPerAxis(first) : planes_mm.empty() ? bare->views : 1;
  const bool even = eyes % 2 == 0;
  nodes.x = CoverRange(AllAims(display, beams, false, nodes.aim, kernel), step, even);
  // A lenticular sheet has no fan along y.
  nodes.y = CoverRange(AllAims(display, beams, true, nodes.aim, kernel), step,
                       even && !HasRowFamilies(first));
  const double size = display.emitter_pitch_mm() / samples_per_pixel;
  nodes.sample_x = {-display.width_mm() / 2, size};
  nodes.sample_y = {-display.height_mm() / 2, size};
  nodes.samples_x.resize(Index(nodes.x.count));
  nodes.samples_y.resize(Index(nodes.y.count));
  for (std::size_t layer = 0; layer < beams.size(); ++layer) {
    const double z = display.layers[layer].position_mm;
    for (int plane = 0; plane < nodes.NumPlanes(); ++plane) {
      for (const auto& family : beams[layer].columns) {
        AddRanges(OverlapsAlongX(nodes, family, z, kernel, plane), nodes.samples_x);
      }
      AddRanges(OverlapsAlongY(nodes, beams[layer].rows, z, kernel, plane), nodes.samples_y);
    }
  }
  return nodes;
}

RayBundle RaysOfNode(const NodeLattice& nodes, int node_x, int node_y) {
  RayBundle bundle;
  const Scatter scatter = ScatterOf(nodes, node_x, node_y);
  const double aim_x = nodes.x.Centre(node_x) + scatter.aim_x * nodes.x.step;
  const double aim_y = -(nodes.y.Centre(node_y) + scatter.aim_y * nodes.y.step);
  if (nodes.aim.points) {
    bundle.centre = {aim_x, aim_y, nodes.aim.distance_mm, 1};
  } else {
    bundle.centre = {aim_x, aim_y, 1, 0};
  }
  const SampleRange &x = nodes.samples_x[Index(node_x)], &y = nodes.samples_y[Index(node_y)];
  const SampleAxis &along_x = nodes.sample_x, &along_y = nodes.sample_y;
  bundle.origin = {along_x.origin_mm + (x.first + scatter.sample_x) * along_x.size_mm,
                   -(along_y.origin_mm + (y.first + scatter.sample_y) * along_y.size_mm), 0};
  bundle.dx = {along_x.size_mm, 0, 0};
  bundle.dy = {0, -along_y.size_mm, 0};
  bundle.width = x.size();
  bundle.height = y.size();
  return bundle;
}

}  // namespace lamella
