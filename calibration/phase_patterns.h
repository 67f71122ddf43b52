// Phase-shifted sinusoids that tell a camera which pixel of a panel it sees (calibration.md
// sections 3 and 4).
#pragma once

#include <string>
#include <vector>

#include "lightfield/image.h"

namespace lamella {

enum class PanelAxis { kU, kV };

// Light 1/2 + m/2 cos(2 pi (u/T - k/N)) at pixel centres u = i + 0.5, in the steps k = 0 .. N-1.
struct PhaseSeries {
  PanelAxis axis = PanelAxis::kU;
  int period_px = 16;  // T
  int steps = 8;       // N
  friend bool operator==(const PhaseSeries&, const PhaseSeries&) = default;
};
std::string NameOf(const PhaseSeries& series);  // "u_0016"

// N = 8 at T = 16 px, N = 4 at T = 128 and, where a panel of this size does not fit into that, at
// T = 2048 and on by at most 16 up to a period that it fits into; u first, each from fine to
// coarse.
std::vector<PhaseSeries> PhaseSeriesOf(int width_px, int height_px);

// Codes of a panel with an sRGB response. Light from 0.02 to 0.98.
Image<Rgb8> DrawPhase(int width_px, int height_px, const PhaseSeries& series, int step);

}  // namespace lamella
