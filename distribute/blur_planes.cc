#include "distribute/blur_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr double kNearestPlane = 0.5;  // in viewing distances

// The step from a plane to the next one: widths are piecewise linear in z.
double StepMm(const std::vector<BeamOfLayer>& beams, double widening, double z) {
  double step = std::numeric_limits<double>::infinity();
  for (const auto& [beam, layer_mm] : beams) {
    const double width =
        std::max(beam.OpeningBlurMm(z - layer_mm) + beam.EmitterBlurMm(z - layer_mm),
                 0.1 * beam.aperture_mm);
    const double change = beam.aperture_mm * std::abs(beam.kappa_per_mm()) +
                          beam.emitter_width_mm / std::abs(beam.d0_mm);
    step = std::min(step, widening * width / change);
  }
  return step;
}

}  // namespace

std::vector<double> BlurPlanes(const Display& display, const std::vector<BeamOfLayer>& beams,
                               double widening, double farthest_mm) {
  std::vector<double> planes{display.layers.front().position_mm};
  if (beams.empty()) return planes;
  while (planes.back() > farthest_mm) {
    planes.push_back(planes.back() - StepMm(beams, widening, planes.back()));
  }
  std::reverse(planes.begin(), planes.end());
  const double nearest =
      std::max(kNearestPlane * display.viewing_distance_mm, display.layers.back().position_mm);
  while (planes.back() < nearest) {
    planes.push_back(std::min(planes.back() + StepMm(beams, widening, planes.back()), nearest));
  }
  return planes;
}

}  // namespace lamella
