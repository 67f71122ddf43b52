// What is measured of emitters and eye pictures.
#pragma once

#include <complex>
#include <vector>

#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"
#include "lightfield/display.h"
#include "lightfield/ray_source.h"

namespace lamella::experiments {

using Complex = std::complex<double>;

// A window of whole lattice periods, and frequencies with whole periods in it, of which none is an
// alias of another: an odd number of lattice periods, frequencies of an even number of periods.
struct Window {
  int lattice_periods = 99;  // odd, and divisible by 3: the pinholes' period is three of theirs
  double lattice_mm = 0;     // Delta x
  double width_mm() const { return lattice_periods * lattice_mm; }
  // The nearest frequency of an even number of periods.
  double Frequency(double about) const;
  // All of them from `least` to `most`.
  std::vector<double> Frequencies(double least, double most) const;
};

// One row of an eye's picture, green.
std::vector<double> RowOf(const EyePicture& picture);

// Complex amplitude of cos(2 pi f x) in pixels of that size around `middle_mm`, without the loss
// sinc(f pixel) by the pixels' own width.
Complex AmplitudeOf(const std::vector<double>& row, double pixel_mm, double middle_mm, double f);

// Amplitudes that far eyes see of waves on the plane z, [slope][frequency].
std::vector<std::vector<Complex>> SeenAmplitudes(const LayerImages& images, const Display& display,
                                                 const Window& window, double z,
                                                 const std::vector<double>& slopes,
                                                 const std::vector<double>& frequencies);

// Modulus of the mean over views of the complex amplitudes, by frequency.
std::vector<double> MeanOverViews(const std::vector<std::vector<Complex>>& amplitudes);

// The same of the emitters themselves: what a perfect display would show of layer 0, each emitter's
// value where the middle of its beam meets the plane z; mean over the directions.
std::vector<double> StoredAmplitudes(const LayerImages& images, const Display& display,
                                     const Window& window, double z,
                                     const std::vector<double>& frequencies);

// Prefilter and display in the mean over views: distributes waves on the plane z and looks at them.
std::vector<double> ChainMtfAt(const Display& display, const Window& window, double z,
                               const std::vector<double>& frequencies, const LayersOptions& options,
                               int views_per_step);

// The first f where mtf/reference falls below sinc(1/2)^stages, interpolated; the last of
// `frequencies` (rising) where it never does (ranieri2012.md section 8).
double CutoffOf(const std::vector<double>& frequencies, const std::vector<double>& mtf,
                const std::vector<double>& reference, int stages);

double Mean(const std::vector<double>& values);
// 10 log10(1 / mean squared difference), linear light.
double PsnrOf(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace lamella::experiments
