// Experiment 14: how much light is seen.
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/display.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

// Mean of what an eye at x sees of 120 mm, as a share of the emitters' luminance.
double SeenShare(const LayerImages& images, const Display& display, double x) {
  Eye eye = FarEye(0, 0, 120, 480);
  eye.position = {x, 0, display.viewing_distance_mm};
  const double open = Brightness(display, display.layers[0]);
  return open * Mean(RowOf(SimulateEye(images, display, eye)));
}

}  // namespace

Experiment SeenBrightness(Effort effort) {
  Experiment experiment;
  experiment.id = "14";
  experiment.claim =
      "A white frame is seen with (a/P)^2/n of the panel's luminance through barriers, 1/n through "
      "lenses, from inside the clean eye box.";
  experiment.set_up =
      "White plane at z = 1 mm, presets cut to 480 px (150 mm) x 12 px; eyes at D on the axis and "
      "at 0.5 and 0.99 of the clean box, lenses without shear.";
  Figure figure{"Seen luminance of a white frame",
                "eye off the axis, mm",
                "share of the panel's luminance",
                {}};
  struct Case {
    std::string name;
    Display display;
    double expected;
  };
  std::vector<Case> cases;
  for (const auto& [name, expected] :
       {std::pair("paper-one-layer", 1.0 / 9), std::pair("paper-two-layer", 1.0 / 18),
        std::pair("paper-two-layer-half", 1.0 / 18)}) {
    Display display = FindDisplay(name);
    display.width_px = 480;
    display.height_px = 12;
    cases.push_back({name, display, expected});
  }
  cases.push_back({"one layer of lenses", Lenses({0}, 241), 1});
  cases.push_back({"two layers of lenses", Lenses({-10, 10}, 241), 0.5});
  const SceneAlongX white([](double, double) { return Seen{1, 1}; });
  for (const Case& c : cases) {
    const LayerImages images = Distribute(white, c.display, Sampling(1, 1), SilentProgress());
    const double box = CleanEyeBox(c.display);
    experiment.rows.push_back(Reported(c.name + ": clean eye box, mm", box));
    Curve curve{c.name, {}, {}};
    for (double share = 0; share <= 2; share += effort == Effort::kQuick ? 0.5 : 0.125) {
      curve.x.push_back(share * box);
      curve.y.push_back(SeenShare(images, c.display, share * box));
    }
    for (const double share : {0.0, 0.5, 0.99}) {
      experiment.rows.push_back(
          Near(fmt::format("{}: seen share, eye at {:.1f} mm", c.name, share * box),
               SeenShare(images, c.display, share * box), c.expected, 1e-4));
    }
    experiment.rows.push_back(
        Reported(c.name + ": seen share at twice the box", SeenShare(images, c.display, 2 * box)));
    figure.curves.push_back(std::move(curve));
  }
  experiment.figures.push_back(std::move(figure));
  experiment.reason =
      "Beyond the clean box the light stays (to twice the box here): what is seen there comes from "
      "a neighbour's window, and emitters that the shear's steps miss are given to the nearest "
      "opening, so that they are not dark.";
  return experiment;
}

}  // namespace lamella::experiments
