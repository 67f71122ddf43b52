// The prefilter as exact overlaps (displays.md section 1.3): how much of an emitter's beam falls
// into each cell of the lattice on which the scene is asked.
//
// On one axis a line is a point of the plane (position, aim): where it crosses a plane parallel to
// the layers, and where it goes: the point it meets on the eye plane z = D (with shear), or its
// slope (without). A beam, all lines from an emitter through an opening, is a parallelogram there.
// The scene is asked at nodes: a node is an aim, its cell the strip of aims around it, its samples
// are the intervals of positions. Weight of a sample = area of beam, strip and interval / area of
// beam.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "distribute/emitter_beams.h"

namespace lamella {

// Centres first + k step, 0 <= k < count: mm on the eye plane, or slopes dx/dz. Rows are counted
// downwards and have their coordinate, -y, running the same way.
struct NodeAxis {
  double first = 0, step = 0;
  int count = 0;
  double Centre(int k) const { return first + k * step; }
};

// Samples on z = 0: sample j spans [origin + j size, origin + (j + 1) size], mm; j may be negative.
struct SampleAxis {
  double origin_mm = 0, size_mm = 0;
};

// The part of a beam that falls into one node's cell.
struct Overlap {
  int slot = 0, emitter = 0, family = 0;  // the beam's
  int first_sample = 0;
  int num_samples = 0;
  std::uint32_t weights = 0;  // index of its num_samples weights in AxisOverlaps::weights
};

// Over which lines an emitter's light is averaged.
enum class Kernel {
  kBeam,  // those it sends: from all of the emitter through all of the element, exactly
  kLens,  // the paper's box in position and slope: element times emitter (a focused lens's beam)
  kRay,   // its central line alone: no prefilter
};

// Of one axis of one layer. A beam's weights sum to 1 over all nodes.
struct AxisOverlaps {
  std::vector<std::vector<Overlap>> nodes;  // each in the order of the beams
  std::vector<float> weights;
};

// The lines of an axis, and where the two families of layers and nodes stand.
struct AimPlane {
  bool points = true;      // aims are points of z = distance_mm; else slopes
  double distance_mm = 0;  // D
};

// Smallest and largest aim of any beam.
struct AimRange {
  double min = 0, max = 0;
};
AimRange AimsOf(std::span<const EmitterBeam> beams, double layer_mm, const AimPlane& aim,
                Kernel kernel = Kernel::kBeam);

// `layer_mm`: the modulating plane. `content_mm`: the plane on which a beam's line and the node's
// ray that stands for it cross. Exact for content there; elsewhere a line is off by at most half a
// cell's parallax, and by none on average over the cell. A beam whose element stands offset_mm in
// front of the layer's plane takes both planes with it.
AxisOverlaps OverlapsOf(std::span<const EmitterBeam> beams, double layer_mm, const AimPlane& aim,
                        double content_mm, const NodeAxis& nodes, const SampleAxis& samples,
                        Kernel kernel = Kernel::kBeam);

}  // namespace lamella
