// Experiment 7: borders that overlap.
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/ray_map.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

constexpr double kGain = 20.0 / 47;  // of the ramp z = gain x
constexpr double kBandMm = 5;        // |z| in which emitters count

// A textured plane that crosses the border between the layers.
class Ramp final : public RaySource {
 public:
  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    for (int j = 0; j < rectangle.height; ++j) {
      for (int i = 0; i < rectangle.width; ++i) {
        const Ray ray = bundle.RayAt(rectangle.x + i + 0.5, rectangle.y + j + 0.5);
        const Eigen::Vector3d slope = ray.direction / ray.direction.z();
        const Eigen::Vector3d at = ray.origin - ray.origin.z() * slope;  // z = 0
        const double z = kGain * at.x() / (1 - kGain * slope.x());
        const float value =
            static_cast<float>(texture_(at.x() + z * slope.x(), at.y() + z * slope.y()));
        samples(i, j) = {{value, value, value}, static_cast<float>(z - bundle.origin.z()), 1, 1};
      }
    }
  }

 private:
  std::function<double(double, double)> texture_ = Texture(5);
};

Display SmallTwoLayers() {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 84;
  display.height_px = 12;
  display.border_offset_mm = 0;
  return display;
}

// The values of all emitters whose central ray meets the ramp in the band.
std::vector<double> InBand(const LayerImages& images, const Display& display) {
  std::vector<double> values;
  for (int layer = 0; layer < 2; ++layer) {
    const RayMap map(display, layer);
    const int k = map.slots_per_axis();
    for (int slot = 0; slot < k * k; ++slot) {
      for (int column = 0; column < map.columns(); ++column) {
        const std::optional<AxisBeam> x = map.Column(slot % k, column);
        if (!x) continue;
        const double z = kGain * x->At(-map.position_mm()) / (1 - kGain * x->slope());
        if (std::abs(z) > kBandMm) continue;
        for (int row = 0; row < map.rows(); ++row) {
          if (!map.Row(slot / k, row)) continue;
          values.push_back(static_cast<double>(
              images.slots[static_cast<std::size_t>(layer)][static_cast<std::size_t>(slot)]
                  .color(column, row)
                  .g));
        }
      }
    }
  }
  return values;
}

// Rays per axis and beam: an opening is two pixels wide.
struct Sampled {
  int m = 0;  // of the beam, all four axes of it
  LayersOptions options;
};

std::vector<Sampled> Samplings(const char* kernel) {
  LayersOptions scattered = Sampling(1, 1, kernel);
  scattered.scatter = true;
  LayersOptions finer = Sampling(2, 1, kernel);
  finer.scatter = true;
  return {{1, Sampling(1, 4, "ray")}, {4, scattered}, {16, finer}};
}

}  // namespace

Experiment FuzzyBorders(Effort effort) {
  Experiment experiment;
  experiment.id = "7";
  experiment.claim =
      "Overlapping borders save samples: for a textured surface through a border, w = 0.2 z_D is "
      "at "
      "least 3 dB nearer to its own fully sampled frames than w = 0 at equal m.";
  experiment.set_up =
      "paper-two-layer, 84x12 px, ramp z = 20 x/47 with the 1/f texture, emitters of rays that "
      "meet "
      "it at |z| < 5 mm; m rays a beam by this program's own sampling: its central ray (1), "
      "scattered nodes 1 and 2 a step (4, 16), against 6 x 4 nodes and samples (9216) of the same "
      "w.";
  const Display display = SmallTwoLayers();
  const Ramp ramp;
  const auto frames = [&](LayersOptions options, double border) {
    options.border_mm = border;
    return InBand(Distribute(ramp, display, options, SilentProgress()), display);
  };
  Figure figure{"Frames in the border band against fully sampled ones of the same border",
                "m",
                "PSNR, dB",
                {}};
  for (const char* kernel : {"lens", "beam"}) {
    if (effort == Effort::kQuick && *kernel == 'b') continue;
    const std::string name = *kernel == 'l' ? "lens beam" : "pinhole beam";
    const bool quick = effort == Effort::kQuick;
    std::vector<Curve> curves;
    for (const double border : {0.0, 4.0, 20.0}) {
      if (quick && border == 20) continue;
      const std::vector<double> full =
          frames(quick ? Sampling(4, 4, kernel) : Sampling(6, 4, kernel), border);
      Curve curve{fmt::format("{}, w = {:g} mm", name, border), {}, {}, *kernel == 'b'};
      for (const Sampled& sampled : Samplings(kernel)) {
        curve.x.push_back(sampled.m);
        curve.y.push_back(PsnrOf(frames(sampled.options, border), full));
        experiment.rows.push_back(
            Reported(fmt::format("{}, m = {}: PSNR, dB", curve.name, sampled.m), curve.y.back()));
      }
      curves.push_back(curve);
    }
    for (std::size_t i = 0; i < curves[0].x.size(); ++i) {
      experiment.rows.push_back(AtLeast(
          fmt::format("{}, m = {:g}: gain of w = 4 mm over w = 0, dB", name, curves[0].x[i]),
          curves[1].y[i] - curves[0].y[i], 3));
    }
    for (Curve& curve : curves) figure.curves.push_back(std::move(curve));
  }
  experiment.figures.push_back(std::move(figure));
  return experiment;
}

}  // namespace lamella::experiments
