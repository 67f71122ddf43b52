// The prefilter as a blur of pictures, driven by depth: every emitter sees the picture of the one
// node that its central ray is nearest to, blurred as wide as its beam is at the depth of what the
// picture shows (the section box(W_a) * box(W_b) of displays.md section 1.3), depth by depth, so
// that what is near and what lies behind it, shadows too, have each their own width.
//
// It takes a node's picture for all of a beam's lines. For a plane at one depth that is right up to
// the samples where a plane of the blur lies, and off by up to 2 % of white between two; where
// things hide others it is an approximation, which distribute/prefilter.h's gather over all nodes
// of a beam is not. It is slower than that gather, too: it is there to be compared with.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "distribute/accumulate.h"
#include "distribute/emitter_beams.h"
#include "distribute/prefilter.h"
#include "lightfield/display.h"
#include "lightfield/image.h"
#include "lightfield/ray_source.h"

namespace lamella {

// BlurPlanes for which overlaps are made: no beam is half as wide again at one as at its neighbour.
// They reach one viewing distance behind the display; what is beyond is blurred as it is there.
// `beams[layer]` is EnclosingBeamsOf.
std::vector<double> DepthBlurPlanes(const Display& display, const std::vector<LayerBeams>& beams);

// As OverlapsOf, of the one node nearest to each beam's central line and the samples that the
// beam's section on z = content_mm is seen in from there. For beams whose elements stand in the
// layer's plane.
AxisOverlaps BlurOverlapsOf(std::span<const EmitterBeam> beams, double layer_mm,
                            const AimPlane& aim, double content_mm, const NodeAxis& nodes,
                            const SampleAxis& samples, Kernel kernel);

// The blur of nodes' samples into the sums of all layers.
class DepthBlur {
 public:
  // No planes: it is off, and has no overlaps.
  DepthBlur(std::vector<double> planes_mm, std::size_t layers)
      : planes_mm_(std::move(planes_mm)), overlaps_(layers) {
    for (std::vector<LayerOverlaps>& layer : overlaps_) layer.resize(planes_mm_.size());
  }
  bool on() const { return !planes_mm_.empty(); }

  // Of BlurOverlapsOf, to be filled by the caller; columns have the same places on all planes.
  LayerOverlaps& Overlaps(int layer, int plane) {
    return overlaps_[static_cast<std::size_t>(layer)][static_cast<std::size_t>(plane)];
  }
  void AddAxesOfRows(std::vector<const AxisOverlaps*>& axes) const;

  void BeginStrip() { unknown_.clear(); }
  // As Accumulate, each sample by the overlaps of the two planes that it lies between, by its
  // distances from them, or by those of the outermost one.
  void Add(const std::vector<NodeSamples>& nodes, int node_y, const LayerWeights& weights,
           std::vector<LayerSums>& sums);
  // Coverage that the strip's emitters have of what is not known; null where all is known.
  const Image<Light>* Unknown(int layer, std::size_t slot) const {
    return unknown_.empty() ? nullptr : &unknown_[static_cast<std::size_t>(layer)].sums.slots[slot];
  }

 private:
  void AddPlanes(const std::vector<NodeSamples>& nodes, int node_y, const LayerWeights& weights,
                 std::vector<LayerSums>& sums);

  std::vector<double> planes_mm_;                     // rising
  std::vector<std::vector<LayerOverlaps>> overlaps_;  // by layer and plane
  std::vector<LayerSums> unknown_;                    // empty while nothing is unknown
  std::vector<Image<RaySample>> of_plane_, missing_;  // room for parts of nodes' samples
};

}  // namespace lamella
