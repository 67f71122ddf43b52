// Counting rays: experiments 3, 11 and 15.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <fmt/format.h>

#include "distribute/assign.h"
#include "distribute/displays.h"
#include "lightfield/bandwidth.h"
#include "lightfield/layer_map.h"
#include "lightfield/ray_map.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

// Emitters, or sub-pixels, that have a beam.
double LitRays(const Display& display) {
  double rays = 0;
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    const Layer& of = display.layers[static_cast<std::size_t>(layer)];
    const LayerMap map(display, layer);
    const int channels = std::holds_alternative<Lenticular>(of.optics) ? 3 : 1;
    for (int row = 0; row < display.emitter_rows(); ++row) {
      for (int column = 0; column < display.emitter_columns(); ++column) {
        for (int channel = 0; channel < channels; ++channel) {
          if (map.BeamOf(0, channel, column, row)) ++rays;
        }
      }
    }
  }
  return rays;
}

// Upright cylinder lenses, `lenses` of them over 12 rows, n layers of 6/n views each.
Display CylinderLenses(int n, int lenses) {
  Display display;
  display.name = "cylinder lenses";
  display.height_px = 12;
  display.width_px = lenses * 6 / n / 3;
  display.pitch_mm = kPitchMm;
  display.viewing_distance_mm = 600;
  display.shear = false;
  Lenticular lenticular;
  lenticular.views = 6 / n;
  lenticular.subpixels_per_lens = lenticular.views;
  lenticular.slant = 0;
  for (const double z : EqualRangePositionsMm(n, kSharpRangeMm)) {
    display.layers.push_back({z, 5, lenticular});
  }
  return display;
}

// The central rays of all emitter columns in all slots: those that there are, and those that enter
// the eye box.
struct RayCount {
  double columns = 0, rays = 0, entering = 0;
};

RayCount CountRays(const Display& display, double box_mm) {
  RayCount count;
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    const RayMap map(display, layer);
    for (int slot = 0; slot < map.slots_per_axis(); ++slot) {
      for (int column = 0; column < map.columns(); ++column) {
        ++count.columns;
        const std::optional<AxisBeam> beam = map.Column(slot, column);
        if (!beam) continue;
        ++count.rays;
        const double at = beam->At(display.viewing_distance_mm - map.position_mm());
        if (std::abs(at) <= box_mm / 2) ++count.entering;
      }
    }
  }
  return count;
}

}  // namespace

Experiment RayCounts(Effort) {
  Experiment experiment;
  experiment.id = "3";
  experiment.claim =
      "n layers of n times coarser directions, which share one layer's range, need 1/n of its rays "
      "with full parallax and as many with horizontal parallax only.";
  experiment.set_up =
      "Lit emitters counted: square lenslets of 6/n x 6/n rays (Delta u' = n Delta u), and upright "
      "cylinder lenses of 6/n views; 21 lenses.";
  Curve full{"full parallax", {}, {}}, horizontal{"horizontal parallax", {}, {}};
  const double one = LitRays(Lenses({0}, 21, 1, 3)), one_h = LitRays(CylinderLenses(1, 21));
  for (const int n : {1, 2, 3, 6}) {
    const double ratio = LitRays(Lenses(EqualRangePositionsMm(n, kSharpRangeMm), 21, n, 3)) / one;
    const double ratio_h = LitRays(CylinderLenses(n, 21)) / one_h;
    full.x.push_back(n);
    full.y.push_back(ratio);
    horizontal.x.push_back(n);
    horizontal.y.push_back(ratio_h);
    if (n == 1) continue;
    experiment.rows.push_back(
        Near(fmt::format("n = {}, full parallax: rays relative to one layer", n), ratio, 1.0 / n,
             1e-12));
    experiment.rows.push_back(
        Near(fmt::format("n = {}, horizontal parallax: rays relative to one layer", n), ratio_h, 1,
             1e-12));
  }
  Curve closed{full.name, {}, {}, Stroke::kClosedForm};
  for (double n = 1; n <= 6; n += 0.1) {
    closed.x.push_back(n);
    closed.y.push_back(1 / n);
  }
  experiment.figures.push_back(
      {"Rays of n layers relative to one", "layers n", "ratio", {full, closed, horizontal}});
  return experiment;
}

Experiment ShearedRays(Effort) {
  Experiment experiment;
  experiment.id = "11";
  experiment.claim =
      "Shearing the fields of view towards the viewer raises the share of rays that reach an eye "
      "box; far away it makes no difference.";
  experiment.set_up =
      "paper-two-layer, whole panels, eye box 65 mm at D; share of all emitter columns whose "
      "central ray enters it, along x. Thin line: 65 d0/(6 p D).";
  Curve plain{"plain", {}, {}}, sheared{"sheared", {}, {}};
  Curve expected{"sheared", {}, {}, Stroke::kClosedForm};
  for (const double d : {300.0, 600.0, 1000.0, 2000.0}) {
    Display display = FindDisplay("paper-two-layer");
    display.viewing_distance_mm = d;
    const RayCount on = CountRays(display, 65);
    display.shear = false;
    const RayCount off = CountRays(display, 65);
    const double with = on.entering / on.columns, without = off.entering / off.columns;
    const double closed = 65 * 5 / (6 * kPitchMm * d);
    for (Curve* curve : {&plain, &sheared}) curve->x.push_back(d);
    plain.y.push_back(without);
    sheared.y.push_back(with);
    experiment.rows.push_back(
        AtLeast(fmt::format("D = {:g} mm: sheared share over plain one", d), with / without, 1));
    experiment.rows.push_back(
        Near(fmt::format("D = {:g} mm: sheared share", d), with, closed, 0.05));
    if (d == 2000) {
      experiment.rows.push_back(
          Near("D = 2000 mm: sheared share over plain one", with / without, 1, 0.05));
      experiment.rows.push_back(Reported("D = 2000 mm: the same, of those columns that have a ray",
                                         on.entering / on.rays / (off.entering / off.rays)));
    }
  }
  for (double d = 300; d <= 2000; d += 20) {
    expected.x.push_back(d);
    expected.y.push_back(65 * 5 / (6 * kPitchMm * d));
  }
  experiment.reason =
      "At 2000 mm the very same rays of plain and sheared fans enter the box. The shear also gives "
      "a ray to eight emitter columns of 11 520 that have none without it, at the panels' edges, "
      "and none of them enters: counted of columns with a ray, its share is smaller by these 0.07 "
      "%.";
  experiment.figures.push_back({"Share of emitters whose ray enters an eye box of 65 mm",
                                "D, mm",
                                "share",
                                {plain, sheared, expected}});
  return experiment;
}

Experiment EnergyPartition(Effort) {
  Experiment experiment;
  experiment.id = "15";
  experiment.claim =
      "Before the prefilter the layers' light fields add up to the incoming one: max |sum - in| <= "
      "1e-6.";
  experiment.set_up =
      "Weights of 1 to 24 layers over 40 000 random depths from -1 m to 1 m, and at both "
      "infinities; borders from hard to the whole spacing; random radiance in [0, 1].";
  std::mt19937 random(3);
  std::uniform_real_distribution<float> depth(-1000, 1000), near(-110, 110), radiance(0, 1);
  Curve curve{"largest difference", {}, {}};
  double worst = 0;
  for (const int n : {1, 2, 3, 4, 6, 24}) {
    const double spacing = 200.0 / n;
    std::vector<double> positions;
    for (int l = 0; l < n; ++l) positions.push_back((l - (n - 1) / 2.0) * spacing);
    double worst_of_n = 0;
    for (const double border : {0.0, 0.2, 0.7, 1 - 1e-9}) {
      const LayerWeights weights(positions, border * spacing);
      for (int i = 0; i < 10000; ++i) {
        float z = i % 2 == 0 ? near(random) : depth(random);
        if (i == 0) z = std::numeric_limits<float>::infinity();
        if (i == 1) z = -std::numeric_limits<float>::infinity();
        const float in = radiance(random);
        float sum = 0;
        for (int l = 0; l < n; ++l) sum += weights.Weight(l, z) * in;
        worst_of_n = std::max(worst_of_n, static_cast<double>(std::abs(sum - in)));
      }
    }
    curve.x.push_back(n);
    curve.y.push_back(1e6 * worst_of_n);
    worst = std::max(worst, worst_of_n);
  }
  experiment.rows.push_back(AtMost("largest |sum of the layers - incoming|", worst, 1e-6));
  experiment.figures.push_back({"What the partition loses, in single precision",
                                "layers n",
                                "largest difference, 1e-6",
                                {curve, {"claim: at most", {1, 24}, {1, 1}, Stroke::kClosedForm}}});
  return experiment;
}

}  // namespace lamella::experiments
