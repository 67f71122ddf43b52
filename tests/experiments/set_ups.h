// The displays and eyes of the experiments (simulation.md sections 1 and 4): as small as the
// measurement allows, most of them one element high, before content that only varies along x.
#pragma once

#include <vector>

#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"
#include "lightfield/display.h"

namespace lamella::experiments {

constexpr double kPitchMm = 0.3113158871666749;  // of the paper's 27" panels
constexpr double kLatticeMm = 2 * kPitchMm;      // Delta x of pinholes and lenses alike
constexpr double kSharpRangeMm = 10;             // z_max of one layer, of both
constexpr double kLensPitchPx = 6;

// Layers of paper-two-layer, at these depths, `columns` x `rows` px, hard borders.
Display Pinholes(const std::vector<double>& positions_mm, int columns, int rows = 6);

// Layers with the beam that the paper's law is about: square lenslets as wide as the lattice, six
// rays of them, f = d0, and the pinholes' Delta x, field of view and sharp range. `binning` n joins
// n x n pixels into an emitter: Delta u' = n Delta u, and 6/n rays.
Display Lenses(const std::vector<double>& positions_mm, int lenses, int binning = 1, int rows = 1);

// n layers that are 2 z_max apart, around z = 0.
std::vector<double> EqualBandwidthPositionsMm(int layers);

// Slope between neighbouring emitters of an element: an emitter step of view.
double StepOfView(const Display& display);

// `per_step` slopes a step, in the middle of the fan, evenly over `steps` whole steps.
std::vector<double> SlopesOverSteps(const Display& display, int steps, int per_step);

// An eye so far away that its lines of sight are parallel; its picture is one pixel high, on the
// plane z = plane_mm, and spans width_mm around the axis there.
Eye FarEye(double slope, double plane_mm, double width_mm, int pixels);

LayersOptions Sampling(int nodes_per_step, int samples_per_pixel, const char* kernel = "beam");

}  // namespace lamella::experiments
