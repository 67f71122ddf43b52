// Rays that are traced together, coordinate by coordinate, in double precision.
#pragma once

#include "lightfield/ray_source.h"

namespace lamella {

inline constexpr int kPacketRays = 16;

struct RayPacket {
  alignas(64) double origin[3][kPacketRays];
  alignas(64) double direction[3][kPacketRays];
  // Hits are looked for at t in (t_min, t_max); t_min may be -infinity, t_max infinity.
  alignas(64) double t_min[kPacketRays];
  alignas(64) double t_max[kPacketRays];
  alignas(64) int active[kPacketRays];  // -1: asked for, 0: not; its numbers are then ignored
  // For shadows: any hit will do, and what lies within 2e-6 of a mesh's radius of t_min may be
  // missed.
  bool any_hit = false;

  Ray At(int i) const {
    return {{origin[0][i], origin[1][i], origin[2][i]},
            {direction[0][i], direction[1][i], direction[2][i]}};
  }
};

struct PacketHits {
  alignas(64) double t[kPacketRays];
  int surface[kPacketRays];   // -1: none
  int triangle[kPacketRays];  // of a mesh
};

}  // namespace lamella
