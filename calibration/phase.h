// From photographs of phase-shifted sinusoids to the panel's point that every pixel sees.
#pragma once

#include <optional>
#include <vector>

#include "calibration/phase_patterns.h"
#include "calibration/screen_map.h"
#include "lightfield/image.h"

namespace lamella {

// The steps of one series, k = 0 .. N-1, in numbers linear in light, 1 full scale.
struct PhasePhotos {
  PhaseSeries series;
  std::vector<ImageSpan<const float>> photos;
};

// Variance of a number: per_light times the number, plus constant.
struct SensorNoise {
  double per_light = 0, constant = 0;
};

// Of one panel, seen without moving: all series of both axes, in any order, and the panel white and
// black.
struct PhaseCapture {
  std::vector<PhasePhotos> series;
  ImageSpan<const float> white, black;
  int width_px = 0, height_px = 0;  // of the panel
  // Seen through lenses (lens_sightings.h): seams between them are everywhere, and within them what
  // is seen is flat. Pixels are left out within 1 px of any without enough light, not 3, and their
  // neighbours' plane is not asked for. The map has its sinusoids.
  bool through_lenses = false;
};

// I_k = A + B cos(phi - 2 pi k/N), phi = 2 pi u/T; every period is unwrapped by the next coarser
// one, with sigma_u = T/(2 pi) sqrt(2/N) sigma_I/B of the finest. Valid are pixels whose
// modulation, contrast and exposure suffice (15 sigma, 10 sigma, 0.95; 3 px from any that
// does not), whose periods agree within a quarter of the finer one, and which lie in their
// neighbours' plane within 4 sigma (calibration.md section 4). The noise, where it is not given, is
// that of the finest series about its sinusoid. InputError where an axis or a step is absent, the
// coarsest period is shorter than the panel, or photographs differ in size.
ScreenMap DecodePhase(const PhaseCapture& capture, const std::optional<SensorNoise>& noise = {});

// The series of one period alone, of modulation too faint to be unwrapped pixel by pixel: u and v
// up to multiples of the period. Valid are pixels whose modulation in the finest series is 3 sigma
// and more, down to an amplitude of 1.5 standard deviations of a photograph's noise. InputError as
// above.
ScreenMap DecodePeriod(const PhaseCapture& capture, int period_px);

}  // namespace lamella
