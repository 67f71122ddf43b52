// A camera's tone curve from photographs of the same light at several exposures: Debevec and Malik
// 1997, "Recovering High Dynamic Range Radiance Maps from Photographs". For files that have no
// linear numbers; those that have are better, since what the shutter is off goes into the curve.
#pragma once

#include <string>
#include <vector>

namespace lamella {

// A patch of even light in one photograph.
struct NumberReading {
  int patch = 0;        // the same light at every exposure
  double exposure = 1;  // as the shutter claims
  double number = 0;    // the photograph's mean, share of full scale
  double variance = 0;  // of it
};

// Light over numbers, both 1 at full scale; between knots a power, below the first one as well.
struct CameraResponse {
  std::vector<double> log_number, log_light;
  double rms = 0;  // of log light over all readings
  double LightOf(double number) const;
};

// Least squares of log light(number) = log patch + log exposure over 16 knots whose logarithms are
// evenly spaced, with the least bend that fits: a power law has none. InputError (naming `where`)
// where fewer than 12 patches are seen at two exposures or more, neither lost nor overexposed, or
// they agree to 10 % only.
CameraResponse EstimateCameraResponse(const std::vector<NumberReading>& readings,
                                      const std::string& where);

}  // namespace lamella
