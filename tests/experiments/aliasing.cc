// Experiment 6: what the prefilter removes.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "distribute/analyze.h"
#include "lightfield/bandwidth.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

constexpr double kPlaneMm = 2 * kSharpRangeMm;
constexpr double kDistanceMm = 600;
constexpr int kAliasingPixels = 960;

// What a camera sees of the grating that moves past the display: the energy at wrong frequencies,
// and the energy of what changes from one picture to the next.
struct Errors {
  double wrong = 0, flicker = 0;
};

// The grating keeps its place in pictures of the plane that it lies in.
Errors Watch(const LayerImages& images, const Display& display, double f, double step_mm) {
  const double width = std::round(36 * f) / f;  // whole periods
  Errors errors;
  std::vector<double> before;
  int frames = 0;
  for (double x = -30; x <= 30; x += step_mm) {
    Eye eye = FarEye(0, kPlaneMm, width, kAliasingPixels);
    eye.position = {x, 0, kDistanceMm};
    const std::vector<double> row = RowOf(SimulateEye(images, display, eye));
    const double mean = Mean(row);
    const Complex amplitude = AmplitudeOf(row, eye.pixel_mm, 0, f);
    double energy = 0, change = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      energy += (row[i] - mean) * (row[i] - mean);
      if (!before.empty()) change += (row[i] - before[i]) * (row[i] - before[i]);
    }
    errors.wrong += energy / kAliasingPixels - std::norm(amplitude) / 2;
    errors.flicker += change / kAliasingPixels;
    before = row;
    ++frames;
  }
  errors.wrong /= frames;
  errors.flicker /= frames - 1;
  return errors;
}

}  // namespace

Experiment Aliasing(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "6";
  experiment.claim =
      "The prefilter removes aliasing: from 1.75 times the cut-off at that depth on, the energy at "
      "wrong frequencies and the flicker of a moving camera drop by at least 10 dB.";
  experiment.set_up =
      "Gratings on z = 20 mm = 2 z_max, one layer at 0 (cut-off 0.40 cycles/mm); pinhole camera at "
      "600 mm from -30 to 30 mm by 2 mm; energy without mean and f, filter on over off.";
  Figure figure{"What the prefilter leaves at wrong frequencies, grating at 2 z_max",
                "f, cycles/mm",
                "energy, filter on over off, dB",
                {}};
  for (const bool lens : {true, false}) {
    const Display display = lens ? Lenses({0}, 91) : Pinholes({0}, 6 * 31);
    const std::string name = lens ? "lenses" : "pinholes";
    Curve wrong{name, {}, {}}, flicker{name, {}, {}};
    std::vector<double> frequencies = {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
    if (quick) frequencies = {0.7};
    for (const double f : frequencies) {
      const SceneAlongX grating([f](double x0, double slope) {
        return Seen{0.5 + 0.5 * std::cos(2 * M_PI * f * (x0 + slope * kPlaneMm)), kPlaneMm};
      });
      const auto watch = [&](const LayersOptions& options) {
        return Watch(Distribute(grating, display, options, SilentProgress()), display, f,
                     quick ? 6 : 2);
      };
      const Errors on = watch(lens ? Sampling(8, 2) : Sampling(6, 3));
      const Errors off = watch(Sampling(1, lens ? 2 : 4, "ray"));
      wrong.x.push_back(f);
      flicker.x.push_back(f);
      wrong.y.push_back(10 * std::log10(on.wrong / off.wrong));
      flicker.y.push_back(10 * std::log10(on.flicker / off.flicker));
      const std::string at = fmt::format("{}, f = {:g}: ", name, f);
      for (const Curve* curve : {&wrong, &flicker}) {
        const std::string what =
            at + (curve == &wrong ? "energy at wrong frequencies, dB" : "flicker, dB");
        experiment.rows.push_back(f >= 0.7 ? AtMost(what, curve->y.back(), -10)
                                           : Reported(what, curve->y.back()));
      }
    }
    figure.curves.push_back(std::move(wrong));
    const AxisBeam beam = MiddleBeam(display, display.layers[0]);
    Curve closed{name, {}, {}, Stroke::kClosedForm};
    for (double f = 0.2; f < 1.005; f += 0.01) {
      closed.x.push_back(f);
      closed.y.push_back(20 * std::log10(std::max(std::abs(Mtf(beam, kPlaneMm, f)), 1e-3)));
    }
    figure.curves.push_back(std::move(closed));
  }
  figure.curves.push_back({"claim: at most", {0.7, 1}, {-10, -10}, Stroke::kClosedForm});
  experiment.figures.push_back(std::move(figure));
  experiment.reason =
      "Of one wave the filter scales what every emitter stores by the beam's S(f) (thin lines: 20 "
      "log10 S), and with it the flicker, whose figures are therefore the same. Near the cut-off "
      "little is gained by lenses, as a box passes part of what it should remove; nothing is "
      "claimed there.";
  return experiment;
}

}  // namespace lamella::experiments
