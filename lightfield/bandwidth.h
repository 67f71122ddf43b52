// Closed forms of what a display can show: how wide its beams are as low-passes, and how fine a
// detail is at a depth (ranieri2012.md section 5; displays.md sections 1.3 and 1.4). Frequencies in
// cycles per mm.
#pragma once

#include <vector>

#include "lightfield/beam.h"

namespace lamella {

// Of a layer whose elements are dx_mm apart and whose directions du_mm on the emissive plane.
double SharpRangeMm(double d0_mm, double dx_mm, double du_mm);  // z_max = d0 dx/du
// Eq. 1 restored: min(d0/(2 du |offset|), 1/(2 dx)).
double CutoffPerMm(double offset_mm, double d0_mm, double dx_mm, double du_mm);
// The same with the beam's real widths: min(1/(2 dx), 1/(2 W_a), 1/(2 W_b)). Equal to Eq. 1 for
// lenses with f = d0 as wide as the lattice; below it where a pinhole's own width spreads
// (ranieri2012.md section 10, 16).
double BeamCutoffPerMm(const AxisBeam& beam, double offset_mm, double dx_mm);

// `layers` of them with n-th part of the directions each, which share the range +- sharp_range_mm
// of one layer that has all (ranieri2012.md section 5, "n layers, equal depth range").
std::vector<double> EqualRangePositionsMm(int layers, double sharp_range_mm);
// Their combined cut-off at depth z: the best layer's.
double CombinedCutoffPerMm(double z_mm, int layers, double d0_mm, double dx_mm, double du_mm);
// Their rays relative to the one layer's, n^(1 - parallax axes): nothing is saved with one axis.
double RayRatio(int layers, int parallax_axes);

// |sinc(f W_a) sinc(f W_b)| (mtf_single), sinc t = sin(pi t)/(pi t): what a beam leaves of a
// frequency at an offset from its modulating plane: the prefilter alone, or the display alone in
// the mean over views and lattice phases.
double Mtf(const AxisBeam& beam, double offset_mm, double frequency);
// Prefilter and display in the mean over views (mtf_chain): its square.
double ChainMtf(const AxisBeam& beam, double offset_mm, double frequency);
// Prefilter and display before one far pinhole eye (mtf_chain_fixed_eye), of a lens's beam: for one
// direction the second angular box is a shift, not a loss.
double FixedEyeChainMtf(const AxisBeam& beam, double offset_mm, double frequency);

// A pupil of this diameter at distance_mm, focused on the plane focus_mm, spreads a point at z_mm
// over a disc; its diameter, measured on the plane of the point (eye_blur).
double EyeBlurMm(double pupil_mm, double distance_mm, double focus_mm, double z_mm);

}  // namespace lamella
