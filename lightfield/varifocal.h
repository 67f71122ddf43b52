// What is special about a display whose planes follow each other in time (displays.md section 5):
// where they are, and their one-bit pictures in the frames of a projector.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "lightfield/display.h"

namespace lamella {

// Of the planes in turn (plane_depths): rising, their middle is 0. Equal steps, or cosine steps
// -cos(pi (k + 1/2)/K), scaled so that the outer planes are depth_mm apart.
std::vector<double> PlaneDepthsMm(const Varifocal& varifocal);

// M0 + z/f (plane_magnification): exact for a thin lens whose image moves by z.
double PlaneMagnification(const Varifocal& varifocal, double z_mm);

// The codes R, G, B of one pixel of a frame that carries 24 planes of one bit each (bitplanes): bit
// k of `planes`, the pixel in plane k, becomes bit k mod 8 of the channel order[k / 8]. `order` is
// a permutation of "RGB", a setting of the projector.
std::array<std::uint8_t, 3> PackBitPlanes(std::uint32_t planes, std::string_view order);

// One pixel's bits in time from its grey value in [0, 1], linear light (sigma_delta): the sum of
// what was shown never differs from the sum of what was asked by more than 1. `accumulator` starts
// anywhere in [0, 1) and is carried on.
bool SigmaDelta(double grey, double& accumulator);

}  // namespace lamella
