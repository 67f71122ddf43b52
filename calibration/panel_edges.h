// Corners seen across an edge of the layer's other panel. An emitter is seen through its modulator
// and a modulator by its emitter's light, so a board ends where the other panel does; a corner
// whose surroundings are cut there is found where it is not, the same way from all positions.
#pragma once

#include <string>
#include <vector>

#include "calibration/observations.h"
#include "calibration/state.h"

namespace lamella {

// Within this of an edge the window that a corner is refined in may be cut, px of the photograph.
inline constexpr double kPanelEdgePx = 21;

// The observations without the points that lie, in their photographs, beyond an edge of the other
// panel or within kPanelEdgePx of it; `state` may be some px off. Photographs and their order stay.
// Where nothing tells where the other panel is, for want of photographs, all points stay.
struct ClearOfEdges {
  Observations observations;
  std::vector<std::string> left_out;  // "layer 0 emitter: 44 points ..." of each panel with such
};
ClearOfEdges WithoutPanelEdges(const CalibrationState& state, const Structure& structure,
                               const Observations& observations);

}  // namespace lamella
