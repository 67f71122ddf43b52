// A display as it might have been built: every part off its place by a random amount.
#pragma once

#include <cstdint>

#include "lightfield/calibration.h"

namespace lamella {

// Largest deviations; each number is drawn evenly between both signs of it.
struct Misalignment {
  double shift_mm = 20;  // of stacks along x, y and z, of emitters in their stacks along x and y
  double turn_deg = 5;   // of stacks about x, y and z, of emitters in their stacks about z
  double scale = 0.005;  // of every panel but the one that gives the length; of a varifocal plane
  double least_gap_mm = 0, most_gap_mm = 0;  // gaps between these; both 0: as designed
};

// The display with every stack and panel misaligned, the same for equal seeds. Emitters are tilted
// in their stacks by a third of the gap at their sides at most, so that they pierce no modulator.
// The first stack that is seen directly keeps its place and its front panel its scale: they are the
// frame and the length that photographs are measured in. Of a varifocal display all planes stand
// off their places instead, each magnified by a factor of its own, with the one panel and lens
// sheet as designed. UsageError where a number is out of range, a varifocal display is given gaps,
// or its planes would change their order.
Calibration Misaligned(const Calibration& design, const Misalignment& by, std::uint32_t seed,
                       bool varifocal = false);

}  // namespace lamella
