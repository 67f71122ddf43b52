#include "lightfield/bandwidth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lamella {
namespace {

double Sinc(double t) {
  const double angle = std::numbers::pi * t;
  return std::abs(angle) < 1e-8 ? 1.0 : std::sin(angle) / angle;
}

}  // namespace

double SharpRangeMm(double d0_mm, double dx_mm, double du_mm) { return d0_mm * dx_mm / du_mm; }

double CutoffPerMm(double offset_mm, double d0_mm, double dx_mm, double du_mm) {
  const double lattice = 1 / (2 * dx_mm);
  if (offset_mm == 0) return lattice;
  return std::min(d0_mm / (2 * du_mm * std::abs(offset_mm)), lattice);
}

double BeamCutoffPerMm(const AxisBeam& beam, double offset_mm, double dx_mm) {
  const double widest =
      std::max({dx_mm, beam.OpeningBlurMm(offset_mm), beam.EmitterBlurMm(offset_mm)});
  return 1 / (2 * widest);
}

std::vector<double> EqualRangePositionsMm(int layers, double sharp_range_mm) {
  std::vector<double> positions;
  for (int l = 0; l < layers; ++l) {
    positions.push_back(-sharp_range_mm + (2 * l + 1) * sharp_range_mm / layers);
  }
  return positions;
}

double CombinedCutoffPerMm(double z_mm, int layers, double d0_mm, double dx_mm, double du_mm) {
  double best = 0;
  for (const double position : EqualRangePositionsMm(layers, SharpRangeMm(d0_mm, dx_mm, du_mm))) {
    best = std::max(best, CutoffPerMm(z_mm - position, d0_mm, dx_mm, layers * du_mm));
  }
  return best;
}

double RayRatio(int layers, int parallax_axes) { return std::pow(layers, 1 - parallax_axes); }

double Mtf(const AxisBeam& beam, double offset_mm, double frequency) {
  return std::abs(Sinc(frequency * beam.OpeningBlurMm(offset_mm)) *
                  Sinc(frequency * beam.EmitterBlurMm(offset_mm)));
}

double ChainMtf(const AxisBeam& beam, double offset_mm, double frequency) {
  const double single = Mtf(beam, offset_mm, frequency);
  return single * single;
}

double FixedEyeChainMtf(const AxisBeam& beam, double offset_mm, double frequency) {
  return Mtf(beam, offset_mm, frequency) *
         std::abs(Sinc(frequency * beam.OpeningBlurMm(offset_mm)));
}

double EyeBlurMm(double pupil_mm, double distance_mm, double focus_mm, double z_mm) {
  return pupil_mm * std::abs(z_mm - focus_mm) / (distance_mm - focus_mm);
}

}  // namespace lamella
