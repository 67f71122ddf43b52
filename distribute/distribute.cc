#include "distribute/distribute.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "distribute/accumulate.h"
#include "distribute/assign.h"
#include "distribute/prefilter.h"
#include "lightfield/parallel.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

// Below this the colour of an emitter, light / coverage, would be rounding noise.
constexpr float kLeastCoverage = 1e-5F;

// The lattice on which the scene is asked, and every layer's overlaps with it.
struct Nodes {
  AimPlane aim;
  NodeAxis x, y;
  SampleAxis sample_x, sample_y;
  std::vector<AxisOverlaps> layers_x, layers_y;
};

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

// Nodes every `step` that cover the range, one of them in the middle of an emitter's fan of aims
// where the period is even as well as where it is odd.
NodeAxis CoverRange(const AimRange& range, double step, bool even) {
  const double offset = even ? 0.5 : 0.0;
  const double first = std::floor(range.min / step - offset + 0.5);
  const double last = std::floor(range.max / step - offset + 0.5);
  return {(first + offset) * step, step, static_cast<int>(last - first) + 1};
}

NodeAxis NodeAxisOf(const std::vector<RayMap>& maps, Axis axis, const AimPlane& aim, double step,
                    bool even) {
  AimRange all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const RayMap& map : maps) {
    const AimRange range = AimsOf(map, axis, aim);
    all.min = std::min(all.min, range.min);
    all.max = std::max(all.max, range.max);
  }
  return CoverRange(all, step, even);
}

Nodes MakeNodes(const Display& display, const std::vector<RayMap>& maps,
                const LayersOptions& options, double d0_mm, bool even) {
  Nodes nodes;
  nodes.aim = {display.shear, display.viewing_distance_mm};
  const double pitch = display.emitter_pitch_mm();
  const double step =
      pitch * (display.shear ? display.viewing_distance_mm : 1.0) / d0_mm / options.nodes_per_step;
  nodes.x = NodeAxisOf(maps, Axis::kColumns, nodes.aim, step, even);
  nodes.y = NodeAxisOf(maps, Axis::kRows, nodes.aim, step, even);
  const double size = pitch / options.samples_per_pixel;
  nodes.sample_x = {-display.width_mm() / 2, size};
  nodes.sample_y = {-display.height_mm() / 2, size};
  for (const RayMap& map : maps) {
    const double content = map.position_mm();
    nodes.layers_x.push_back(
        OverlapsOf(map, Axis::kColumns, nodes.aim, content, nodes.x, nodes.sample_x));
    nodes.layers_y.push_back(
        OverlapsOf(map, Axis::kRows, nodes.aim, content, nodes.y, nodes.sample_y));
  }
  return nodes;
}

struct SampleRange {
  int first = 0, end = 0;
  int size() const { return end - first; }
};

// The samples of a node that any layer needs.
SampleRange SamplesOf(const std::vector<AxisOverlaps>& layers, int node) {
  SampleRange range{std::numeric_limits<int>::max(), std::numeric_limits<int>::min()};
  for (const AxisOverlaps& layer : layers) {
    for (const Overlap& overlap : layer.nodes[Index(node)]) {
      range.first = std::min(range.first, overlap.first_sample);
      range.end = std::max(range.end, overlap.first_sample + overlap.num_samples);
    }
  }
  return range.first < range.end ? range : SampleRange{};
}

int MostSamples(const std::vector<AxisOverlaps>& layers, int nodes) {
  int most = 0;
  for (int node = 0; node < nodes; ++node) most = std::max(most, SamplesOf(layers, node).size());
  return most;
}

// Room for the samples of any node.
struct NodeBuffers {
  explicit NodeBuffers(const Nodes& nodes)
      : samples(MostSamples(nodes.layers_x, nodes.x.count),
                MostSamples(nodes.layers_y, nodes.y.count)),
        light(samples.width(), samples.height()) {}
  Image<RaySample> samples;
  Image<Light> light;
};

// The rays of a node through the samples of z = 0.
RayBundle BundleOf(const Nodes& nodes, int node_x, int node_y, const SampleRange& x,
                   const SampleRange& y) {
  RayBundle bundle;
  const double aim_x = nodes.x.Centre(node_x), aim_y = -nodes.y.Centre(node_y);
  if (nodes.aim.points) {
    bundle.centre = {aim_x, aim_y, nodes.aim.distance_mm, 1};
  } else {
    bundle.centre = {aim_x, aim_y, 1, 0};
  }
  bundle.origin = {nodes.sample_x.origin_mm + x.first * nodes.sample_x.size_mm,
                   -(nodes.sample_y.origin_mm + y.first * nodes.sample_y.size_mm), 0};
  bundle.dx = {nodes.sample_x.size_mm, 0, 0};
  bundle.dy = {0, -nodes.sample_y.size_mm, 0};
  bundle.width = x.size();
  bundle.height = y.size();
  return bundle;
}

// What a layer shows of the samples: their light by its weight, black where another layer shows
// them (a shadow), and nothing where nothing is known.
void WeightSamples(ImageSpan<const RaySample> samples, const LayerWeights& weights, int layer,
                   ImageSpan<Light> out) {
  ParallelFor(0, samples.height, 32, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < samples.width; ++x) {
        const RaySample& sample = samples(x, y);
        const float light = sample.color.r + sample.color.g + sample.color.b;
        if (!(sample.coverage > 0 && std::isfinite(light))) {
          out(x, y) = Light();
          continue;
        }
        const float scale = weights.Weight(layer, sample.z) * sample.coverage;
        out(x, y) = {scale * sample.color.r, scale * sample.color.g, scale * sample.color.b,
                     sample.coverage};
      }
    }
  });
}

EmitterImage Normalised(Image<Light> sums) {
  EmitterImage image{Image<Rgb>(sums.width(), sums.height()),
                     Image<float>(sums.width(), sums.height())};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const Light& sum = sums.data()[i];
    if (sum.coverage < kLeastCoverage) continue;
    const float scale = 1 / sum.coverage;
    image.color.data()[i] = {scale * sum.r, scale * sum.g, scale * sum.b};
    image.coverage.data()[i] = std::min(sum.coverage, 1.0F);
  }
  return image;
}

// Layers of one gap share their nodes.
struct LayerGroup {
  std::vector<int> layers;
  std::vector<RayMap> maps;
};

std::vector<LayerGroup> GroupLayers(const Display& display) {
  std::map<double, LayerGroup> by_gap;
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    LayerGroup& group = by_gap[display.layers[Index(layer)].d0_mm];
    group.layers.push_back(layer);
    group.maps.emplace_back(display, layer);
  }
  std::vector<LayerGroup> groups;
  for (auto& [gap, group] : by_gap) groups.push_back(std::move(group));
  return groups;
}

LayerWeights WeightsOf(const Display& display, const LayersOptions& options) {
  const double offset = options.border_offset_mm.value_or(display.border_offset_mm);
  std::vector<double> positions;
  for (const Layer& layer : display.layers) positions.push_back(layer.position_mm + offset);
  return {positions, options.border_mm.value_or(display.border_mm)};
}

class Distributor {
 public:
  Distributor(const RaySource& source, const Display& display, const LayersOptions& options)
      : source_(source), display_(display), weights_(WeightsOf(display, options)) {
    for (LayerGroup& group : GroupLayers(display)) {
      const Layer& first = display.layers[Index(group.layers[0])];
      nodes_.push_back(MakeNodes(display, group.maps, options, first.d0_mm,
                                 BarrierOf(display, Index(group.layers[0])).period_px % 2 == 0));
      groups_.push_back(std::move(group));
    }
  }

  std::vector<std::vector<EmitterImage>> Run(Progress& progress) {
    std::int64_t total = 0;
    for (const Nodes& nodes : nodes_) total += std::int64_t{nodes.x.count} * nodes.y.count;
    progress.Start("layers", total, "nodes");
    std::vector<std::vector<EmitterImage>> images(display_.layers.size());
    for (std::size_t g = 0; g < groups_.size(); ++g)
      RunGroup(groups_[g], nodes_[g], progress, images);
    return images;
  }

 private:
  EmitterSums MakeSums(int layer) const {
    const int k = SlotsPerAxis(display_.layers[Index(layer)]);
    EmitterSums sums{k, {}};
    for (int slot = 0; slot < k * k; ++slot) {
      sums.slots.emplace_back(display_.emitter_columns(), display_.emitter_rows());
    }
    return sums;
  }

  void RunGroup(const LayerGroup& group, const Nodes& nodes, Progress& progress,
                std::vector<std::vector<EmitterImage>>& images) const {
    std::vector<EmitterSums> sums;
    for (const int layer : group.layers) sums.push_back(MakeSums(layer));
    NodeBuffers buffers(nodes);
    for (int node_y = 0; node_y < nodes.y.count; ++node_y) {
      for (int node_x = 0; node_x < nodes.x.count; ++node_x) {
        AddNode(group, nodes, node_x, node_y, buffers, sums);
        progress.Advance();
      }
    }
    for (std::size_t i = 0; i < group.layers.size(); ++i) {
      for (Image<Light>& slot : sums[i].slots) {
        images[Index(group.layers[i])].push_back(Normalised(std::move(slot)));
      }
    }
  }

  void AddNode(const LayerGroup& group, const Nodes& nodes, int node_x, int node_y,
               NodeBuffers& buffers, std::vector<EmitterSums>& sums) const {
    const SampleRange x = SamplesOf(nodes.layers_x, node_x), y = SamplesOf(nodes.layers_y, node_y);
    if (x.size() == 0 || y.size() == 0) return;
    const RayBundle bundle = BundleOf(nodes, node_x, node_y, x, y);
    const Rect all{0, 0, bundle.width, bundle.height};
    const ImageSpan<RaySample> samples = buffers.samples.span().Sub(all);
    const ImageSpan<Light> light = buffers.light.span().Sub(all);
    source_.Query(bundle, all, samples);
    for (std::size_t i = 0; i < group.layers.size(); ++i) {
      WeightSamples(samples, weights_, group.layers[i], light);
      Accumulate(light, x.first, y.first, nodes.layers_x[i], node_x, nodes.layers_y[i], node_y,
                 sums[i]);
    }
  }

  const RaySource& source_;
  const Display& display_;
  const LayerWeights weights_;
  std::vector<LayerGroup> groups_;
  std::vector<Nodes> nodes_;
};

// Indices whose beam's centre passes within half_mm of the axis on z = 0; none for missed emitters.
std::vector<int> BeamsWithin(const RayMap& map, Axis axis, int slot, double half_mm) {
  std::vector<int> indices;
  const int count = axis == Axis::kColumns ? map.columns() : map.rows();
  for (int index = 0; index < count; ++index) {
    const std::optional<AxisBeam> beam =
        axis == Axis::kColumns ? map.Column(slot, index) : map.Row(slot, index);
    if (beam && std::abs(beam->At(-map.position_mm())) <= half_mm) indices.push_back(index);
  }
  return indices;
}

}  // namespace

LayerImages Distribute(const RaySource& source, const Display& display,
                       const LayersOptions& options, Progress& progress) {
  Check(display, display.name);
  RequireBarriers(display);
  LayerImages images;
  images.slots = Distributor(source, display, options).Run(progress);
  images.seen_share = SeenShare(images, display, std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity());
  return images;
}

double SeenShare(const LayerImages& images, const Display& display, double width_mm,
                 double height_mm) {
  double seen = 0, rays = 0;
  for (std::size_t layer = 0; layer < images.slots.size(); ++layer) {
    const RayMap map(display, static_cast<int>(layer));
    for (int slot = 0; slot < static_cast<int>(images.slots[layer].size()); ++slot) {
      const int k = map.slots_per_axis();
      const std::vector<int> columns = BeamsWithin(map, Axis::kColumns, slot % k, width_mm / 2);
      const Image<float>& coverage = images.slots[layer][Index(slot)].coverage;
      for (const int row : BeamsWithin(map, Axis::kRows, slot / k, height_mm / 2)) {
        for (const int column : columns) seen += static_cast<double>(coverage(column, row));
        rays += static_cast<double>(columns.size());
      }
    }
  }
  return rays > 0 ? seen / rays : 0;
}

OptionTable Describe(LayersOptions& options) {
  OptionTable table{
      "layers",
      {{"display",
        "a display's name (see `lamella displays`) or TOML file",
        &options.display,
        {},
        {},
        {},
        "--display"},
       {"nodes_per_step",
        "directions per axis and emitter step for which the capture is rendered",
        &options.nodes_per_step,
        1,
        8,
        {},
        "--nodes-per-step"},
       {"samples_per_pixel",
        "rays per axis and emitter pitch of a rendered direction",
        &options.samples_per_pixel,
        1,
        8,
        {},
        "--samples-per-pixel"},
       {"border_mm",
        "width over which neighbouring layers overlap, mm (default: the display's)",
        &options.border_mm,
        0,
        1e6,
        {},
        "--border-mm"},
       {"border_offset_mm",
        "borders lie so far in front of the middles between layers, mm (default: the display's)",
        &options.border_offset_mm,
        -1e6,
        1e6,
        {},
        "--border-offset-mm"}}};
  for (OptionField& field : Describe(options.placement)) table.fields.push_back(std::move(field));
  return table;
}

// hci_antinous on paper-two-layer, 540 x 540 px, dB of the simulated eyes within +-54 mm: 1 node
// and 1 sample 35.44, 1 and 2 35.51, 2 and 1 35.55, 2 and 2 35.56, at 1, 4, 4 and 15 times the
// rays.
void ApplyQuality(Quality quality, LayersOptions& options) {
  options.nodes_per_step = quality == Quality::kBest ? 2 : 1;
  options.samples_per_pixel = 1;
}

}  // namespace lamella
