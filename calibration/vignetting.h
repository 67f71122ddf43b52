// The camera's vignetting, a display's fall-off with the angle and its unevenness, told apart by
// photographs of white from several directions (calibration.md section 9).
#pragma once

#include <string>
#include <vector>

#include "lightfield/calibration.h"

namespace lamella {

// The panel's cells, row by row from its top left, as the panel is addressed.
inline constexpr int kGainColumns = 8, kGainRows = 5;

// A part of one layer's white in one photograph.
struct WhiteReading {
  int layer = 0, view = 0;
  double x = 0, y = 0;  // its middle, shares of the panel's width and height
  double light = 0;     // mean less the dark frame's, in one unit for all photographs
  double variance = 0;  // of it
  double radius2 = 0;   // squared distance from the picture's middle, 1 in its corners
  double cosine = 1;    // of the line of sight to the layer's normal
};

struct LayerEvenness {
  double falloff = 0, falloff_sd = 0;  // light falls as cosine^falloff
  GainMap gains;                       // their mean 1
  double largest_gain_sd = 0;
};

struct Evenness {
  std::vector<LayerEvenness> layers;
  // The camera's light falls as exp(u1 r^2 + u2 r^4 + u3 r^6).
  std::vector<double> vignetting;
  double rms = 0;  // of the readings' relative residuals
};

double VignettingAt(const Evenness& evenness, double radius2);

// Weighted least squares of log light = log gain (bilinear between the cells' middles) + u1 r^2 +
// u2 r^4 + u3 r^6 + falloff log cosine; weights 1/((sd/light)^2 + (1e-3)^2). Deviations are
// the larger ones of two: of errors of single readings (times the root of chi^2 per degree of
// freedom above 1), and of errors that a photograph's readings share. Every layer with readings
// needs 3 views or more. InputError (naming `display`, and the photographs to add) where there are
// fewer, a fall-off is not known to 0.16 or a cell's gain to 1 %: directions are too much alike.
Evenness FitEvenness(const std::vector<WhiteReading>& readings, int num_layers,
                     const std::string& display);

}  // namespace lamella
