// In which order, and when, a mirror that swings there and back shows a varifocal display's planes
// (displays.md section 5; ranieri2012.md section 10, items 11 and 12).
#pragma once

#include <vector>

#include "lightfield/display.h"

namespace lamella {

// How the focus moves during a stroke, from the back to the front or back.
enum class FocusSweep {
  kUniform,     // at constant speed, turning at once (a triangle)
  kSinusoidal,  // a membrane in resonance
};

struct ShownPlane {
  int plane = 0;     // 0 at the back
  double phase = 0;  // middle of its exposure, as a share of the stroke, in (0, 1)
};

// Planes as one stroke shows them, by time: even strokes rise from the back to the front, odd ones
// fall. The sweep reaches so far that its K equal shares of time have the outer planes in the
// middles of the first and the last: with planes spaced as the sweep moves (Varifocal::Spacing of
// the same name) phases are (i + 1/2)/K; others have to be timed apart.
std::vector<ShownPlane> StrokeSchedule(const Varifocal& varifocal, FocusSweep sweep, int stroke);

// The planes alone: 0 ... K - 1 in even strokes, K - 1 ... 0 in odd ones.
std::vector<int> StrokeOrder(int planes, int stroke);

}  // namespace lamella
