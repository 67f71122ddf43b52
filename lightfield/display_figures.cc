// What follows from a display's numbers (displays.md sections 1 to 3; ranieri2012.md section 5).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lightfield/bandwidth.h"
#include "lightfield/display.h"

namespace lamella {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

// Lengths along a row, in emitters; of a bare panel all but its eye box.
struct Widths {
  double fan = 0;        // of the emitters that an element shows
  double lattice = 0;    // from element to element, of all slots
  double aperture = 0;   // of an element
  double direction = 1;  // from direction to direction
  double emitter = 1;
  double focal_mm = 0;  // 0: d0
  bool lens = true;
};

Widths WidthsOf(const Optics& optics) {
  return std::visit(
      Overloaded{[](const Barrier& b) {
                   return Widths{
                       1.0 * b.period_px, 1.0 * b.stride_px(), 1.0 * b.aperture_px, 1, 1, 0, false};
                 },
                 [](const LensletArray& l) {
                   return Widths{1.0 * l.rays, l.pitch_px, l.pitch_px, 1, 1, l.focal_mm, true};
                 },
                 [](const Lenticular& l) {
                   const double width = l.subpixels_per_lens / 3;
                   return Widths{width, width, width, width / l.views, 1.0 / 3.0, l.focal_mm, true};
                 },
                 [](const BarePanel&) { return Widths{0, 1, 1, 0, 1, 0, false}; }},
      optics);
}

}  // namespace

double LensletArray::row_pitch_px() const {
  return lattice == Lattice::kHexagonal ? pitch_px * std::numbers::sqrt3 / 2 : pitch_px;
}

double LensPowerPerMm(const Layer& layer, double focal_mm) {
  // A relay stretches all lengths along z by M^2.
  const double seen = focal_mm == 0 ? layer.d0_mm : focal_mm;
  return 1 / (layer.magnification * layer.magnification * seen);
}

double ReachMm(const Display& display, const Layer& layer) {
  return std::holds_alternative<BarePanel>(layer.optics) ? display.distance_mm(layer)
                                                         : layer.seen_d0_mm();
}

double FieldOfViewDeg(const Display& display, const Layer& layer) {
  const BarePanel* bare = std::get_if<BarePanel>(&layer.optics);
  const double window = bare != nullptr
                            ? bare->eye_box_mm
                            : WidthsOf(layer.optics).fan * display.emitter_pitch_mm(layer);
  return 2 * std::atan(window / (2 * ReachMm(display, layer))) * 180 / std::numbers::pi;
}

int DirectionsPerAxis(const Layer& layer) {
  return std::visit(
      Overloaded{[](const Barrier& b) { return b.period_px; },
                 [](const LensletArray& l) { return l.rays; },
                 [](const Lenticular& l) { return l.views; }, [](const BarePanel&) { return 1; }},
      layer.optics);
}

double LatticePitchMm(const Display& display, const Layer& layer) {
  return WidthsOf(layer.optics).lattice * display.emitter_pitch_mm(layer);
}

double DirectionStepMm(const Display& display, const Layer& layer) {
  if (const auto* bare = std::get_if<BarePanel>(&layer.optics)) return bare->eye_box_mm;
  return WidthsOf(layer.optics).direction * display.emitter_pitch_mm(layer);
}

double AimStep(const Display& display, const Layer& layer) {
  const double reach = ReachMm(display, layer);
  if (const auto* bare = std::get_if<BarePanel>(&layer.optics)) {
    return bare->eye_box_mm / bare->views / (display.shear ? 1 : reach);
  }
  return DirectionStepMm(display, layer) / reach *
         (display.shear ? display.viewing_distance_mm : 1.0);
}

double SharpRangeMm(const Display& display, const Layer& layer) {
  return SharpRangeMm(ReachMm(display, layer), LatticePitchMm(display, layer),
                      DirectionStepMm(display, layer));
}

double SharpestOffsetMm(const Layer& layer) {
  if (std::holds_alternative<BarePanel>(layer.optics)) return 0;
  const Widths widths = WidthsOf(layer.optics);
  const double opening = widths.aperture / widths.emitter;
  double k = 1;  // d0 * kappa
  if (widths.lens) k = widths.focal_mm == 0 ? 0 : 1 - layer.d0_mm / widths.focal_mm;
  return -layer.seen_d0_mm() * k * opening * opening / (k * k * opening * opening + 1);
}

double MeanSharpestOffsetMm(const std::vector<Layer>& layers) {
  double sum = 0;
  for (const Layer& layer : layers) sum += SharpestOffsetMm(layer);
  return layers.empty() ? 0 : sum / static_cast<double>(layers.size());
}

double CutoffPerMm(const Display& display, const Layer& layer, double offset_mm) {
  return CutoffPerMm(offset_mm, ReachMm(display, layer), LatticePitchMm(display, layer),
                     DirectionStepMm(display, layer));
}

double ViewSpacingMm(const Display& display, const Layer& layer, double distance_mm) {
  return DirectionStepMm(display, layer) * distance_mm / ReachMm(display, layer);
}

double WindowPitchMm(const Display& display, const Layer& layer) {
  const Barrier* barrier = std::get_if<Barrier>(&layer.optics);
  const double pitch = barrier != nullptr ? barrier->period_px * display.emitter_pitch_mm(layer)
                                          : LatticePitchMm(display, layer);
  const double distance = display.distance_mm(layer);
  return display.shear ? pitch * (distance + layer.seen_d0_mm()) / distance : pitch;
}

double Brightness(const Display& display, const Layer& layer) {
  const Barrier* barrier = std::get_if<Barrier>(&layer.optics);
  const double open =
      barrier != nullptr ? static_cast<double>(barrier->aperture_px) / barrier->period_px : 1.0;
  return open * open / static_cast<double>(display.layers.size());
}

double GuardShare(const Layer& layer) {
  const LensletArray* lenses = std::get_if<LensletArray>(&layer.optics);
  if (lenses == nullptr) return 0;
  const double lit = lenses->rays * lenses->rays / (lenses->pitch_px * lenses->row_pitch_px());
  return std::max(0.0, 1 - lit);
}

double DepthBudgetMm(const Display& display) {
  double budget = 0;
  for (const Layer& layer : display.layers) {
    budget = std::max(budget, std::abs(layer.position_mm) + SharpRangeMm(display, layer));
  }
  return budget;
}

}  // namespace lamella
