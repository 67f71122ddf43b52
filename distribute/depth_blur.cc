#include "distribute/depth_blur.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "distribute/blur_planes.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// By how much of itself a beam's width may change from plane to plane.
constexpr double kWidening = 0.5;
constexpr double kFarthestPlane = -1;  // in viewing distances

// The integral of box(a) * box(b), of areas 1, from -inf to t.
double AreaOfSection(double a, double b, double t) {
  const auto ramp = [](double x) { return x > 0 ? x * x / 2 : 0.0; };
  const double sum = (a + b) / 2, difference = (a - b) / 2;
  if (t >= sum) return 1;
  return (ramp(t + sum) - ramp(t + difference) - ramp(t - difference)) / (a * b);
}

struct Section {
  double middle = 0;  // on the samples' plane
  double a = 0, b = 0;
};

void AddSection(const Section& section, const SampleAxis& samples, const EmitterBeam& beam,
                AxisOverlaps& overlaps, std::vector<Overlap>& node) {
  const double reach = (section.a + section.b) / 2;
  const auto sample_of = [&](double position) {
    return static_cast<int>(std::floor((position - samples.origin_mm) / samples.size_mm));
  };
  const int first = sample_of(section.middle - reach), last = sample_of(section.middle + reach);
  node.push_back({beam.slot, beam.emitter, beam.family, first, last - first + 1,
                  static_cast<std::uint32_t>(overlaps.weights.size())});
  double before = 0;
  for (int j = first; j <= last; ++j) {
    const double edge = samples.origin_mm + (j + 1) * samples.size_mm - section.middle;
    const double until = j == last ? 1 : AreaOfSection(section.a, section.b, edge);
    overlaps.weights.push_back(static_cast<float>(std::max(until - before, 0.0)));
    before = until;
  }
}

struct Share {
  int plane = 0;  // and the next one
  float of_next = 0;
};

// What is not a number lies farthest.
Share ShareOf(const std::vector<double>& planes, float depth) {
  const double z = static_cast<double>(depth);
  if (!(z > planes.front())) return {0, 0};
  if (z >= planes.back()) return {static_cast<int>(planes.size()) - 1, 0};
  const auto next = std::upper_bound(planes.begin(), planes.end(), z);
  const int plane = static_cast<int>(next - planes.begin()) - 1;
  const double behind = planes[Index(plane)];
  return {plane, static_cast<float>((z - behind) / (*next - behind))};
}

// The planes that have a share in any of the samples.
void MarkPlanes(ImageSpan<const RaySample> samples, const std::vector<double>& planes,
                std::vector<bool>& seen) {
  for (int y = 0; y < samples.height; ++y) {
    for (int x = 0; x < samples.width; ++x) {
      if (!(samples(x, y).coverage > 0)) continue;
      const Share share = ShareOf(planes, samples(x, y).z);
      seen[Index(share.plane)] = true;
      if (share.of_next > 0) seen[Index(share.plane + 1)] = true;
    }
  }
}

// Room of a node's samples' size.
ImageSpan<RaySample> RoomFor(ImageSpan<const RaySample> samples, Image<RaySample>& room) {
  if (room.width() < samples.width || room.height() < samples.height) {
    room = {};
    room = Image<RaySample>(samples.width, samples.height);
  }
  return room.span().Sub({0, 0, samples.width, samples.height});
}

// The samples with their coverage times their shares in a plane; the shares sum to 1.
void TakePlane(ImageSpan<const RaySample> samples, const std::vector<double>& planes, int plane,
               ImageSpan<RaySample> out) {
  ParallelForEach(0, samples.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < samples.width; ++x) {
      const Share share = ShareOf(planes, samples(x, y).z);
      float taken = 0;
      if (share.plane == plane) taken = 1 - share.of_next;
      if (share.plane + 1 == plane) taken = share.of_next;
      out(x, y) = samples(x, y);
      out(x, y).coverage *= taken;
    }
  });
}

// What is not known of the samples, as black ones; false where all is. What has no depth is as
// sharp as on z = 0.
bool TakeUnknown(ImageSpan<const RaySample> samples, ImageSpan<RaySample> out) {
  bool any = false;
  for (int y = 0; y < samples.height; ++y) {
    for (int x = 0; x < samples.width; ++x) {
      const RaySample& sample = samples(x, y);
      const bool known =
          sample.coverage > 0 && std::isfinite(sample.color.r + sample.color.g + sample.color.b);
      out(x, y) = {{}, known ? sample.z : 0, 0, known ? 1 - sample.coverage : 1};
      any |= out(x, y).coverage > 0;
    }
  }
  return any;
}

// Sums of zeros like others.
std::vector<LayerSums> ZerosLike(const std::vector<LayerSums>& sums) {
  std::vector<LayerSums> zeros(sums.size());
  for (std::size_t l = 0; l < sums.size(); ++l) {
    zeros[l].sums.slots_per_axis = sums[l].sums.slots_per_axis;
    zeros[l].sums.first_row = sums[l].sums.first_row;
    for (const Image<Light>& slot : sums[l].sums.slots) {
      zeros[l].sums.slots.emplace_back(slot.width(), slot.height());
    }
  }
  return zeros;
}

}  // namespace

std::vector<double> DepthBlurPlanes(const Display& display, const std::vector<LayerBeams>& beams) {
  std::vector<BeamOfLayer> of_layers;
  for (std::size_t layer = 0; layer < beams.size(); ++layer) {
    const std::vector<EmitterBeam>& columns = beams[layer].columns.at(0);
    // One stands for all: they are equally wide.
    if (!columns.empty()) of_layers.push_back({columns[0].beam, display.layers[layer].position_mm});
  }
  return BlurPlanes(display, of_layers, kWidening, kFarthestPlane * display.viewing_distance_mm);
}

AxisOverlaps BlurOverlapsOf(std::span<const EmitterBeam> beams, double layer_mm,
                            const AimPlane& aim, double content_mm, const NodeAxis& nodes,
                            const SampleAxis& samples, Kernel kernel) {
  AxisOverlaps overlaps;
  overlaps.nodes.resize(Index(nodes.count));
  if (nodes.count == 0) return overlaps;
  const double offset = content_mm - layer_mm;
  // Of lengths, seen from a node's point.
  const double stretch = aim.points ? aim.distance_mm / (aim.distance_mm - content_mm) : 1.0;
  // A section has an area to divide by, however narrow a beam is.
  const double least = 1e-3 * samples.size_mm;
  for (const EmitterBeam& emitter : beams) {
    const AxisBeam& beam = emitter.beam;
    const double towards = aim.points ? beam.At(aim.distance_mm - layer_mm) : beam.slope();
    const int k =
        std::clamp(static_cast<int>(std::floor((towards - nodes.first) / nodes.step + 0.5)), 0,
                   nodes.count - 1);
    const double node = nodes.Centre(k), at = beam.At(offset);
    Section section;
    section.middle = aim.points ? node + (at - node) * stretch : at - node * content_mm;
    if (kernel == Kernel::kBeam) section.a = stretch * beam.OpeningBlurMm(offset);
    if (kernel == Kernel::kLens) section.a = stretch * beam.aperture_mm;
    if (kernel != Kernel::kRay) section.b = stretch * beam.EmitterBlurMm(offset);
    section.a = std::max(section.a, least);
    section.b = std::max(section.b, least);
    if (section.a < section.b) std::swap(section.a, section.b);
    AddSection(section, samples, emitter, overlaps, overlaps.nodes[Index(k)]);
  }
  return overlaps;
}

void DepthBlur::AddAxesOfRows(std::vector<const AxisOverlaps*>& axes) const {
  for (const std::vector<LayerOverlaps>& layer : overlaps_) {
    for (const LayerOverlaps& plane : layer) axes.push_back(&plane.y);
  }
}

void DepthBlur::AddPlanes(const std::vector<NodeSamples>& nodes, int node_y,
                          const LayerWeights& weights, std::vector<LayerSums>& sums) {
  std::vector<bool> seen(planes_mm_.size());
  for (const NodeSamples& node : nodes) MarkPlanes(node.samples, planes_mm_, seen);
  of_plane_.resize(std::max(of_plane_.size(), nodes.size()));
  for (std::size_t plane = 0; plane < seen.size(); ++plane) {
    if (!seen[plane]) continue;
    std::vector<NodeSamples> taken = nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const ImageSpan<RaySample> room = RoomFor(nodes[i].samples, of_plane_[i]);
      TakePlane(nodes[i].samples, planes_mm_, static_cast<int>(plane), room);
      taken[i].samples = room;
    }
    const auto swap_overlaps = [&] {
      for (std::size_t l = 0; l < sums.size(); ++l) {
        std::swap(sums[l].overlaps, overlaps_[l][plane]);
      }
    };
    swap_overlaps();
    Accumulate(taken, node_y, weights, sums);
    swap_overlaps();
  }
}

void DepthBlur::Add(const std::vector<NodeSamples>& nodes, int node_y, const LayerWeights& weights,
                    std::vector<LayerSums>& sums) {
  AddPlanes(nodes, node_y, weights, sums);
  std::vector<NodeSamples> missing = nodes;
  missing_.resize(std::max(missing_.size(), nodes.size()));
  bool any = false;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ImageSpan<RaySample> room = RoomFor(nodes[i].samples, missing_[i]);
    any |= TakeUnknown(nodes[i].samples, room);
    missing[i].samples = room;
  }
  if (!any) return;
  if (unknown_.empty()) unknown_ = ZerosLike(sums);
  AddPlanes(missing, node_y, weights, unknown_);
}

}  // namespace lamella
