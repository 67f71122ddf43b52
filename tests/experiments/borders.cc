// Experiment 7: borders that overlap.
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/parallel.h"
#include "lightfield/ray_map.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

constexpr double kGain = 20.0 / 47;  // of the ramp z = gain x
constexpr double kBandMm = 5;        // |z| in which emitters count
constexpr double kGapMm = 5;

// The line (x + slope_x z, y + slope_y z).
struct Line {
  double x = 0, y = 0, slope_x = 0, slope_y = 0;
};

Line LineOf(const Ray& ray) {
  const Eigen::Vector3d slope = ray.direction / ray.direction.z();
  const Eigen::Vector3d at = ray.origin - ray.origin.z() * slope;
  return {at.x(), at.y(), slope.x(), slope.y()};
}

// A textured plane that crosses the border between the layers.
class Ramp : public RaySource {
 public:
  explicit Ramp(const std::function<double(double, double)>& texture) : texture_(texture) {}

  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    ParallelForEach(0, rectangle.height, [&](std::int64_t row) {
      const int j = static_cast<int>(row);
      for (int i = 0; i < rectangle.width; ++i) {
        const Line line = Moved(LineOf(bundle.RayAt(rectangle.x + i + 0.5, rectangle.y + j + 0.5)));
        const double z = kGain * line.x / (1 - kGain * line.slope_x);
        const float value =
            static_cast<float>(texture_(line.x + z * line.slope_x, line.y + z * line.slope_y));
        samples(i, j) = {{value, value, value}, static_cast<float>(z - bundle.origin.z()), 1, 1};
      }
    });
  }

 protected:
  virtual Line Moved(const Line& line) const { return line; }

 private:
  const std::function<double(double, double)>& texture_;
};

// Asked along a beam's central ray, answers along the `index`-th of its stochastic rays (Algorithm
// 2): element and emitter by the additive sequence in four dimensions of distribute/nodes.h, from a
// random start of each ray.
class RandomLineOfBeam final : public Ramp {
 public:
  RandomLineOfBeam(const std::function<double(double, double)>& texture, bool lens, double layer_mm,
                   int index)
      : Ramp(texture), lens_(lens), layer_mm_(layer_mm), index_(index) {}

 protected:
  Line Moved(const Line& line) const override {
    // A central ray runs between samples, which are asked in its stead: they are one ray.
    std::uint64_t state = 0;
    for (const double key :
         {(line.x + layer_mm_ * line.slope_x) / kPitchMm,
          (line.y + layer_mm_ * line.slope_y) / kPitchMm, line.slope_x * 1e6, line.slope_y * 1e6}) {
      state = Mixed(state ^ static_cast<std::uint64_t>(std::llround(key)));
    }
    double step = 1;
    const auto next = [&] {
      step /= 1.1673039782614187;
      state = Mixed(state);
      const double at = static_cast<double>(state >> 11) * 0x1p-53 + index_ * step;
      return at - std::floor(at) - 0.5;
    };
    const double a_x = next() * kLatticeMm, a_y = next() * kLatticeMm;
    const double b_x = next() * kPitchMm, b_y = next() * kPitchMm;
    Line moved = line;
    moved.slope_x += (lens_ ? -b_x : a_x - b_x) / kGapMm;
    moved.slope_y += (lens_ ? -b_y : a_y - b_y) / kGapMm;
    moved.x += a_x - layer_mm_ * (moved.slope_x - line.slope_x);
    moved.y += a_y - layer_mm_ * (moved.slope_y - line.slope_y);
    return moved;
  }

 private:
  // Steele et al. 2014, "Fast splittable pseudorandom number generators".
  static std::uint64_t Mixed(std::uint64_t z) {
    z += 0x9e3779b97f4a7c15U;
    z = (z ^ z >> 30U) * 0xbf58476d1ce4e5b9U;
    z = (z ^ z >> 27U) * 0x94d049bb133111ebU;
    return z ^ z >> 31U;
  }

  bool lens_;
  double layer_mm_;
  int index_;
};

Display SmallTwoLayers() {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 84;
  display.height_px = 12;
  display.shear = false;  // so that nodes have the very directions of the emitters
  return display;
}

// The values of a layer's emitters whose central ray meets the ramp in the band.
void AppendInBand(const LayerImages& images, const Display& display, int layer,
                  std::vector<double>& values) {
  const RayMap map(display, layer);
  const int k = map.slots_per_axis();
  for (int slot = 0; slot < k * k; ++slot) {
    const Image<Rgb>& color =
        images.slots[static_cast<std::size_t>(layer)][static_cast<std::size_t>(slot)].color;
    for (int column = 0; column < map.columns(); ++column) {
      const std::optional<AxisBeam> x = map.Column(slot % k, column);
      if (!x) continue;
      const double z = kGain * x->At(-map.position_mm()) / (1 - kGain * x->slope());
      if (std::abs(z) > kBandMm) continue;
      for (int row = 0; row < map.rows(); ++row) {
        if (map.Row(slot / k, row)) values.push_back(static_cast<double>(color(column, row).g));
      }
    }
  }
}

std::vector<double> InBand(const RaySource& source, const Display& display, LayersOptions options,
                           double border_mm) {
  options.border_mm = border_mm;
  const LayerImages images = Distribute(source, display, options, SilentProgress());
  std::vector<double> values;
  for (int layer = 0; layer < 2; ++layer) AppendInBand(images, display, layer, values);
  return values;
}

// One stochastic ray of every beam.
std::vector<double> OneRayEach(const std::function<double(double, double)>& texture,
                               const Display& display, bool lens, int index, double border_mm) {
  LayersOptions options = Sampling(1, 8, "ray");
  options.border_mm = border_mm;
  std::vector<double> values;
  for (int layer = 0; layer < 2; ++layer) {
    const RandomLineOfBeam source(
        texture, lens, display.layers[static_cast<std::size_t>(layer)].position_mm, index);
    AppendInBand(Distribute(source, display, options, SilentProgress()), display, layer, values);
  }
  return values;
}

// PSNR of frames of 1, 4 and 16 stochastic rays a beam, and of the program's own sampling; the
// first counts of them only.
struct Convergence {
  std::array<double, 3> random{}, own{};
};
constexpr std::array<int, 3> kRays = {1, 4, 16};

Convergence Converge(const std::function<double(double, double)>& texture, const Display& display,
                     bool lens, double border_mm, std::size_t num_counts) {
  const char* kernel = lens ? "lens" : "beam";
  const Ramp ramp(texture);
  const std::vector<double> full = InBand(ramp, display, Sampling(6, 4, kernel), border_mm);
  Convergence psnr;
  std::vector<double> sum(full.size(), 0);
  std::size_t at = 0;
  for (int m = 1; m <= kRays[num_counts - 1]; ++m) {
    const std::vector<double> values = OneRayEach(texture, display, lens, m, border_mm);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += values[i];
    if (m != kRays[at]) continue;
    std::vector<double> mean = sum;
    for (double& value : mean) value /= m;
    psnr.random[at++] = PsnrOf(mean, full);
  }
  LayersOptions scattered = Sampling(1, 1, kernel), finer = Sampling(2, 1, kernel);
  scattered.scatter = finer.scatter = true;
  psnr.own = {PsnrOf(InBand(ramp, display, Sampling(1, 8, "ray"), border_mm), full),
              PsnrOf(InBand(ramp, display, scattered, border_mm), full),
              PsnrOf(InBand(ramp, display, finer, border_mm), full)};
  return psnr;
}

}  // namespace

Experiment FuzzyBorders(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  const std::size_t num_counts = quick ? 2 : kRays.size();
  Experiment experiment;
  experiment.id = "7";
  experiment.claim =
      "Overlapping borders save samples: for a textured surface through a border, w = 0.2 z_D is "
      "at least 3 dB nearer to its own fully sampled frames than w = 0 at equal m.";
  experiment.set_up =
      "paper-two-layer, 84x12 px, no shear, ramp z = 20 x/47 with the 1/f texture, emitters of "
      "rays that meet it at |z| < 5 mm; m stochastic rays a beam (Algorithm 2), against 6 nodes a "
      "step and 4 samples a pixel of the same w. Reported beside it: the program's own sampling, "
      "that is central rays, and scattered nodes 1 and 2 a step (4 and 16 rays a beam).";
  const Display display = SmallTwoLayers();
  const std::function<double(double, double)> texture = Texture(5);
  Figure figure{"Frames in the border band against fully sampled ones of the same border",
                "m, rays a beam",
                "PSNR, dB",
                {},
                true};
  for (const bool lens : {true, false}) {
    if (quick && !lens) continue;
    const std::string beam = lens ? "lens beam" : "pinhole beam";
    const Convergence hard = Converge(texture, display, lens, 0, num_counts),
                      fuzzy = Converge(texture, display, lens, 4, num_counts);
    for (std::size_t i = 0; i < num_counts; ++i) {
      const std::string at = fmt::format("{}, m = {}: ", beam, kRays[i]);
      experiment.rows.push_back(Reported(at + "PSNR with w = 0, dB", hard.random[i]));
      experiment.rows.push_back(Reported(at + "PSNR with w = 4 mm, dB", fuzzy.random[i]));
      experiment.rows.push_back(
          AtLeast(at + "gain of w = 4 mm, dB", fuzzy.random[i] - hard.random[i], 3));
      experiment.rows.push_back(Reported(at + "the same gain with the program's own sampling, dB",
                                         fuzzy.own[i] - hard.own[i]));
    }
    const std::vector<double> m(kRays.begin(), kRays.end());
    const auto curve = [&](double w, const Convergence& c) {
      figure.curves.push_back({fmt::format("{}, w = {:g} mm", beam, w),
                               m,
                               {c.random.begin(), c.random.end()},
                               lens ? Stroke::kMeasured : Stroke::kSecond,
                               fmt::format("lens beam, w = {:g} mm", w)});
    };
    curve(0, hard);
    curve(4, fuzzy);
    if (!quick && lens) curve(20, Converge(texture, display, lens, 20, num_counts));
  }
  experiment.figures.push_back(std::move(figure));
  experiment.reason =
      "The gain belongs to stochastic rays. Nodes and samples of this program are stratified, and "
      "every beam takes the exact part of each cell, so that hard borders cost it less to begin "
      "with.";
  return experiment;
}

}  // namespace lamella::experiments
