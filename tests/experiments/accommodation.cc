// Experiment 12: where an eye focuses.
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/set_ups.h"
#include "tests/reference/analytic_scene.h"

namespace lamella::experiments {
namespace {

constexpr double kPointMm = 1.5;  // half width of the "point": more than a ray of each lens near it
constexpr int kPixels = 72;

// paper-varifocal's lenses, cut to 104x68 px; all of its planes, or one at z = 0.
Display Varifocal(bool planes) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 104;
  display.height_px = 68;
  if (planes) return display;
  Layer layer = display.layers[display.layers.size() / 2];
  layer.position_mm = 0;
  display.varifocal.reset();
  display.layers = {layer};
  return display;
}

// Energy of the differences between neighbouring pixels, of a picture of unit mean: what blur takes
// away first.
double SharpnessAt(const LayerImages& images, const Display& display, double focus_mm) {
  Eye eye;
  eye.position = {0, 0, display.viewing_distance_mm};
  eye.plane_mm = focus_mm;
  // Of equal angle, whatever the focus.
  const double scale = (display.viewing_distance_mm - focus_mm) / display.viewing_distance_mm;
  eye.pixel_mm = 8.0 / kPixels * scale;
  eye.left_mm = -kPixels * eye.pixel_mm / 2;
  eye.top_mm = kPixels * eye.pixel_mm / 2;
  eye.width = eye.height = kPixels;
  const EyePicture picture = SimulateEye(images, display, eye, Pupil{4, 16});
  double sum = 0, energy = 0;
  for (int y = 0; y + 1 < kPixels; ++y) {
    for (int x = 0; x + 1 < kPixels; ++x) {
      const double here = static_cast<double>(picture.color(x, y).g);
      const double right = static_cast<double>(picture.color(x + 1, y).g) - here;
      const double below = static_cast<double>(picture.color(x, y + 1).g) - here;
      sum += here;
      energy += right * right + below * below;
    }
  }
  return energy / (sum * sum);
}

struct Focus {
  std::vector<double> planes_mm, sharpness;
  double sharpest_mm = 0;
};

Focus Sweep(const Display& display, double point_mm, double from_mm, double to_mm, double step_mm) {
  AnalyticScene scene;
  scene.rectangles = {{point_mm, -kPointMm, kPointMm, -kPointMm, kPointMm, [](double, double) {
                         return Rgb{1, 1, 1};
                       }}};
  LayersOptions options = Sampling(1, 1);
  options.border_mm = 0;
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  Focus focus;
  double best = 0;
  for (double z = from_mm; z <= to_mm; z += step_mm) {
    focus.planes_mm.push_back(z);
    focus.sharpness.push_back(SharpnessAt(images, display, z));
    if (focus.sharpness.back() > best) {
      best = focus.sharpness.back();
      focus.sharpest_mm = z;
    }
  }
  for (double& s : focus.sharpness) s /= best;
  return focus;
}

}  // namespace

Experiment Accommodation(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "12";
  experiment.claim =
      "More layers, better accommodation: a point is sharpest when the eye focuses within half a "
      "spacing of its depth with 24 planes, and at the layer with one.";
  experiment.set_up =
      "paper-varifocal, 104x68 px, hard borders, eye at 500 mm with a 4 mm pupil; a square of 3 mm "
      "at z; focus by steps of 2 mm within 10 mm of it (24 planes) or from -60 to 60 mm (one).";
  const double half_spacing = 188.0 / 23 / 2;
  Figure figure{"Sharpness over the eye's focus", "focus, mm", "edge energy over the largest", {}};
  const Display many = Varifocal(true);
  for (const double z : {-94.0, -57.0, 0.0, 30.0, 82.0}) {
    if (quick && z != 30) continue;
    const double step = quick ? 4 : 2;
    const Focus focus = Sweep(many, z, z - 10, z + 10, step);
    experiment.rows.push_back(
        AtMost(fmt::format("24 planes, point at {:g} mm: sharpest focus is off by, mm", z),
               std::abs(focus.sharpest_mm - z), half_spacing));
    figure.curves.push_back(
        {fmt::format("24 planes, z = {:g}", z), focus.planes_mm, focus.sharpness});
  }
  const Display one = Varifocal(false);
  for (const double z : {-40.0, 30.0}) {
    if (quick && z != 30) continue;
    const Focus focus = Sweep(one, z, -60, 60, 4);
    experiment.rows.push_back(AtMost(
        fmt::format("one layer at 0, point at {:g} mm: sharpest focus is off the layer by, mm", z),
        std::abs(focus.sharpest_mm), half_spacing));
    figure.curves.push_back(
        {fmt::format("one layer, z = {:g}", z), focus.planes_mm, focus.sharpness, Stroke::kSecond});
  }
  experiment.figures.push_back(std::move(figure));
  experiment.reason =
      "A point halfway between two planes is half a spacing from either; the focus goes to the "
      "plane that shows it.";
  return experiment;
}

}  // namespace lamella::experiments
