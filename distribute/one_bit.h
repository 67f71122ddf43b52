// Grey by bits: what a projector that only knows on and off shows of a varifocal display's planes
// in a number of strokes (displays.md section 5; ranieri2012.md section 9, item 5).
//
// An eye adds up the strokes, the planes that lie on one line of sight, and neighbouring lenses in
// one direction. So errors are evened out in time, along rays, and from lens to lens of one
// direction; never between adjacent emitters, which belong to different views.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "distribute/distribute.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// The mean over all S strokes is right to 1/S.
enum class OneBitMethod {
  // Every emitter on its own adds up what it was asked for and shows 1 when the sum reaches 1
  // (SigmaDelta). Sums start at blue noise.
  kSigmaDelta,
  // Every emitter and stroke on its own compares with a threshold: S of them spread over [0, 1),
  // moved by blue noise, in van der Corput's order from a start that another blue noise gives.
  kOrdered,
  // Floyd and Steinberg's error diffusion in the picture of one direction: how many of its S
  // strokes an emitter is on for is rounded, and the error goes to the neighbouring lenses' counts.
  // Strokes are spread in time as by kSigmaDelta. S = 1 is error diffusion of bits.
  kDiffusion,
};

// "sigma-delta", "ordered", "diffusion".
std::vector<std::string> OneBitMethodNames();
// UsageError with the nearest name where there is none such.
OneBitMethod OneBitMethodOf(std::string_view name);

constexpr int kMaxBitPlanes = 24;  // that one RGB frame carries

struct OneBitOptions {
  OneBitMethod method = OneBitMethod::kSigmaDelta;
  int strokes = 16;  // S, 1 ... 4096
  // Sigma-delta: where neighbouring planes show the same ray (a point between two planes is split
  // between them) the front one's sum starts where the back one's ended, so that the light of both
  // together is right to 1/S, too.
  bool couple_planes = true;
};

// strokes[t](x, y): bit k is the emitter in plane k, 0 at the back, in stroke t. Of the layers'
// emitters, not yet of the panel's pixels (distribute/encode_varifocal.h).
struct BitPlanes {
  int planes = 0;
  std::vector<Image<std::uint32_t>> strokes;
};

// The grey of a monochrome projector: Rec. 709 luminance, linear light, clamped to [0, 1]; unknown
// emitters and NaN are 0.
Image<float> GreyOf(const EmitterImage& emitters);

// grey[k]: of layer k, [0, 1], linear light. Guard pixels, and 0, are off in all strokes; 1 is on
// in all. The same bits for any number of threads. UsageError where a layer has no lenslets, for
// more than kMaxBitPlanes layers, for pictures that are not the layers', and for bad options.
BitPlanes OneBitPlanes(const std::vector<Image<float>>& grey, const Display& display,
                       const OneBitOptions& options);

// What an eye adds up of a plane's emitters: the share of the strokes in which each is on.
Image<float> MeanOfStrokes(const BitPlanes& bits, int plane);

}  // namespace lamella
