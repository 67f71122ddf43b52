// A panel's response from photographs of it showing one code everywhere (calibration.md section 9):
//   light(d) = black + (1 - black) d^gamma,  d the code's share of white's, white 1
// or a monotone table where that does not hold.
#pragma once

#include <string>
#include <vector>

#include "lightfield/calibration.h"

namespace lamella {

// The photograph of one code.
struct FlatReading {
  double code = 0;   // share of white's, 0 to 1
  int exposure = 0;  // a number of its own for every exposure
  double light = 0;  // the panel's mean, in any unit, less that of the same exposure's dark frame
  double variance = 0;  // of it: shot and read noise over the number of pixels
};

struct ResponseFit {
  ToneCurve curve;  // kGamma, or kTable with 33 knots
  double black = 0, black_sd = 0;
  double gamma = 0, gamma_sd = 0;     // of the nearest gamma, also where the curve is a table
  double gamma_residual = 0;          // the farthest level from it, share of white
  std::vector<double> white_light;    // of every exposure (0: not used), in the readings' unit
  std::vector<double> levels, light;  // the codes' measured light, white 1
};

// Above this share of white a gamma does not describe a panel.
inline constexpr double kMostGammaResidual = 0.005;

// Every exposure has a gain of its own, which the levels that it shares with others fix: how long
// the shutter was really open does not matter. Weights are 1/(variance + (1e-3 light)^2).
// Deviations are those of the readings, times the root of chi^2 per degree of freedom above 1.
// InputError (naming `panel`) where white, black or three levels between are missing, or an
// exposure shares no level above its noise with the others.
ResponseFit FitResponse(const std::vector<FlatReading>& readings, const std::string& panel);

}  // namespace lamella
