#include "lightfield/beam.h"

#include <cmath>

namespace lamella {

double AxisBeam::OpeningBlurMm(double offset_mm) const {
  return aperture_mm * std::abs(1 + offset_mm / d0_mm - offset_mm * power_per_mm);
}

double AxisBeam::EmitterBlurMm(double offset_mm) const {
  return emitter_width_mm * std::abs(offset_mm / d0_mm);
}

}  // namespace lamella
