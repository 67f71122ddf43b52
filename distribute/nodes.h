// The lattice on which a scene is asked for a display: nodes (points of the eye plane, or slopes),
// each with rays through samples of z = 0.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "distribute/prefilter.h"
#include "lightfield/display.h"
#include "lightfield/ray_source.h"

namespace lamella {

// Indices [first, end) on a SampleAxis.
struct SampleRange {
  int first = 0, end = 0;
  int size() const { return end - first; }
};

// The samples that the overlaps of any of the axes need at a node; an empty one where none.
SampleRange SamplesOf(const std::vector<const AxisOverlaps*>& axes, int node);

struct NodeLattice {
  AimPlane aim;
  NodeAxis x, y;
  SampleAxis sample_x, sample_y;
  std::vector<SampleRange> samples_x, samples_y;  // of every node: what any layer needs
  bool scatter = false;           // nodes and samples lie anywhere in their cells (see RaysOfNode)
  std::vector<double> planes_mm;  // of the blur (distribute/depth_blur.h); none: the gather
  int NumPlanes() const { return std::max(1, static_cast<int>(planes_mm.size())); }
};

// Overlaps of a layer's beams with the lattice: the gather's, or those of one of the blur's planes.
AxisOverlaps OverlapsAlongX(const NodeLattice& nodes, std::span<const EmitterBeam> columns,
                            double layer_mm, Kernel kernel, int plane);
AxisOverlaps OverlapsAlongY(const NodeLattice& nodes, std::span<const EmitterBeam> rows,
                            double layer_mm, Kernel kernel, int plane);

// `nodes_per_step` nodes per step between neighbouring directions of the finest layer,
// `samples_per_pixel` samples per emitter pitch of z = 0; beams[layer] is EnclosingBeamsOf.
NodeLattice NodesFor(const Display& display, const std::vector<LayerBeams>& beams,
                     int nodes_per_step, int samples_per_pixel, Kernel kernel,
                     const std::vector<double>& planes_mm = {});

// The rays of a node through its samples; width or height is 0 where no layer needs it. With
// `scatter` its aim and its samples are moved within their cells by the node's point of the
// additive sequence in four dimensions whose steps are powers of 1/1.1673, the root of x^5 = x + 1
// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"). Cells keep their
// weights, so that the mean over the nodes stays unbiased.
RayBundle RaysOfNode(const NodeLattice& nodes, int node_x, int node_y);

}  // namespace lamella
