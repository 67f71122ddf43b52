// Square markers with an identity: 6 x 6 modules within a black border of one.
//
// Any two of them differ in 7 modules or more however they are turned, and also where one is seen
// in a mirror, so that a mirrored photograph shows no false identity and tells that it is mirrored.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace lamella {

inline constexpr int kMarkerModules = 6;      // a side, without the border
inline constexpr int kMarkerSideModules = 8;  // with it
inline constexpr int kNumMarkers = 1000;

// Bit i + 6 j is module (i, j), from the top left, set where it is white.
using MarkerBits = std::uint64_t;
MarkerBits BitsOfMarker(int id);

// How a marker lies in a frame whose corners 0 to 3 run clockwise from its top left: the marker's
// corner c (top left, top right, bottom right, bottom left) is the frame's corner (c + turns) mod
// 4, or (turns - c) mod 4 where it is mirrored.
struct MarkerTurn {
  int turns = 0;
  bool mirrored = false;
  int CornerOf(int c) const { return ((mirrored ? turns - c : turns + c) + 4) % 4; }
};

struct KnownMarker {
  int id = 0;
  MarkerTurn turn;
};
// The marker whose modules these are as read in such a frame; up to two may be wrong.
std::optional<KnownMarker> FindMarker(MarkerBits read);

}  // namespace lamella
