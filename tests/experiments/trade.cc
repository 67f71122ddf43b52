// Speed for accuracy: what the samples, the kernel and the implementation of the prefilter cost,
// and what eyes get for it. No claim of the paper; docs/accuracy.md has the other stages.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/layer_map.h"
#include "lightfield/parallel.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"
#include "tests/reference/analytic_scene.h"
#include "tests/reference/distribute_reference.h"

namespace lamella::experiments {
namespace {

// Textured rectangles from 20 mm behind to 20 mm before z = 0, the foremost one dark
// (simulation.md section 3 with Z = 20).
AnalyticScene Rectangles() {
  const auto grey = [](unsigned seed) {
    return [texture = Texture(seed)](double x, double y) {
      const float value = static_cast<float>(texture(x, y));
      return Rgb{value, value, value};
    };
  };
  AnalyticScene scene;
  scene.rectangles = {{-20, -1e9, 1e9, -1e9, 1e9, grey(1)},
                      {-10, -30, -12, -14, 4, grey(2)},
                      {0, -10, 10, -15, 3, grey(3)},
                      {10, 12, 30, -6, 14, grey(4)},
                      {20, -24, -10, 4, 14, [](double, double) { return Rgb{}; }}};
  return scene;
}

// Counts the rays that a scene is asked for.
class Counted final : public RaySource {
 public:
  explicit Counted(const RaySource& source) : source_(source) {}
  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    rays_ += static_cast<std::int64_t>(rectangle.width) * rectangle.height;
    source_.Query(bundle, rectangle, samples);
  }
  double rays() const { return static_cast<double>(rays_); }

 private:
  const RaySource& source_;
  mutable std::atomic<std::int64_t> rays_{0};
};

Display CutTwoLayers(int columns, int rows) {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = columns;
  display.height_px = rows;
  return display;
}

// A place of an opening and of an emitter in [-1/2, 1/2]^2 each: the `index`-th point of the
// additive sequence of distribute/nodes.h from a beam's own start.
struct PlaceInBeam {
  Eigen::Vector2d a, b;
};

PlaceInBeam PlaceOf(std::uint64_t beam, int index) {
  constexpr double kRoot = 1.1673039782614187;
  double place[4], step = 1;
  std::uint64_t state = beam * 0x9e3779b97f4a7c15U + 1;
  for (double& p : place) {
    step /= kRoot;
    state ^= state >> 30U;
    state *= 0xbf58476d1ce4e5b9U;
    state ^= state >> 27U;
    const double at = static_cast<double>(state >> 11U) * 0x1p-53 + index * step;
    p = at - std::floor(at) - 0.5;
  }
  return {{place[0], place[1]}, {place[2], place[3]}};
}

// Algorithm 2 as the paper lists it: `rays` rays of every beam, each asked on its own.
LayerImages StochasticRays(const AnalyticScene& scene, const Display& display, int rays) {
  LayerImages images;
  const int slots = SlotsPerAxis(display.layers[0]) * SlotsPerAxis(display.layers[0]);
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    const LayerMap map(display, layer);
    images.slots.emplace_back();
    for (int slot = 0; slot < slots; ++slot) {
      EmitterImage image{Image<Rgb>(display.emitter_columns(), display.emitter_rows()),
                         Image<float>(display.emitter_columns(), display.emitter_rows())};
      ParallelForEach(0, image.color.height(), [&](std::int64_t at) {
        const int row = static_cast<int>(at);
        for (int column = 0; column < image.color.width(); ++column) {
          const std::optional<Beam> beam = map.BeamOf(slot, 0, column, row);
          if (!beam) continue;
          const std::uint64_t key =
              ((static_cast<std::uint64_t>(layer) * 64 + static_cast<std::uint64_t>(slot)) * 4096 +
               static_cast<std::uint64_t>(row)) *
                  4096 +
              static_cast<std::uint64_t>(column);
          double light = 0;
          for (int i = 0; i < rays; ++i) {
            const PlaceInBeam place = PlaceOf(key, i);
            const RaySample sample =
                scene.Trace(ReferenceRay(*beam, map.position_mm(), place.a, place.b, false));
            light += ReferenceWeight(display, layer, static_cast<double>(sample.z)) *
                     static_cast<double>(sample.color.g);
          }
          const float mean = static_cast<float>(light / rays);
          image.color(column, row) = {mean, mean, mean};
          image.coverage(column, row) = 1;
        }
      });
      images.slots.back().push_back(std::move(image));
    }
  }
  return images;
}

double LitEmitters(const Display& display) {
  double lit = 0;
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    const RayMap map(display, layer);
    for (int slot_x = 0; slot_x < map.slots_per_axis(); ++slot_x) {
      for (int slot_y = 0; slot_y < map.slots_per_axis(); ++slot_y) {
        int columns = 0, rows = 0;
        for (int c = 0; c < map.columns(); ++c) columns += map.Column(slot_x, c) ? 1 : 0;
        for (int r = 0; r < map.rows(); ++r) rows += map.Row(slot_y, r) ? 1 : 0;
        lit += static_cast<double>(columns) * rows;
      }
    }
  }
  return lit;
}

// Eyes inside the clean box; pixels of p on z = 0, of the picture without a rim.
std::vector<Eye> Eyes(const Display& display) {
  std::vector<Eye> eyes;
  for (const double x : {0.0, 32.0, 54.0}) {
    Eye eye;
    eye.position = {x, 0, display.viewing_distance_mm};
    eye.pixel_mm = kPitchMm;
    eye.width = display.width_px - 48;
    eye.height = display.height_px - 24;
    eye.left_mm = -eye.width * eye.pixel_mm / 2;
    eye.top_mm = eye.height * eye.pixel_mm / 2;
    eyes.push_back(eye);
  }
  return eyes;
}

std::vector<double> SeenBy(const std::vector<Eye>& eyes, const LayerImages& images,
                           const Display& display) {
  std::vector<double> seen;
  for (const Eye& eye : eyes) {
    const EyePicture picture = SimulateEye(images, display, eye);
    for (std::size_t i = 0; i < picture.color.size(); ++i) {
      seen.push_back(static_cast<double>(picture.color.data()[i].g));
    }
  }
  return seen;
}

// The scene along the eyes' lines of sight, kSplit x kSplit of them a pixel.
std::vector<double> Target(const std::vector<Eye>& eyes, const RaySource& scene) {
  constexpr int kSplit = 8;
  std::vector<double> target;
  for (const Eye& eye : eyes) {
    const RayBundle bundle = BundleOfEye(eye, kSplit);
    Image<RaySample> samples(bundle.width, bundle.height);
    scene.Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
    for (int y = 0; y < eye.height; ++y) {
      for (int x = 0; x < eye.width; ++x) {
        double sum = 0;
        for (int s = 0; s < kSplit * kSplit; ++s) {
          sum += static_cast<double>(
              samples(x * kSplit + s % kSplit, y * kSplit + s / kSplit).color.g);
        }
        target.push_back(sum / (kSplit * kSplit));
      }
    }
  }
  return target;
}

// One way to make the layers.
struct Way {
  std::string curve;
  LayersOptions options;
  int stochastic_rays = 0;  // 0: the program's own, by the options
};

std::vector<Way> Ways(bool quick) {
  std::vector<Way> ways;
  const auto add = [&](const char* curve, const char* kernel, bool scatter, int nodes,
                       int samples) {
    Way way{curve, Sampling(nodes, samples, kernel), 0};
    way.options.scatter = scatter;
    ways.push_back(std::move(way));
  };
  for (const int nodes : {1, 2, 3, 4}) {
    if (quick && nodes > 2) break;
    add("beam", "beam", false, nodes, 1);
  }
  if (quick) return ways;
  for (const int samples : {2, 3}) add("beam, finer samples", "beam", false, 1, samples);
  for (const int nodes : {1, 2, 3, 4}) add("beam, scattered", "beam", true, nodes, 1);
  for (const int nodes : {1, 2, 3}) add("lens kernel", "lens", false, nodes, 1);
  for (const int nodes : {1, 2}) {
    add("blur by depth", "beam", false, nodes, 1);
    ways.back().options.prefilter = "blur";
  }
  for (const int samples : {1, 2, 4}) add("no prefilter", "ray", false, 1, samples);
  for (const int rays : {1, 4, 16, 64}) {
    ways.push_back({"Algorithm 2", {}, rays});
  }
  return ways;
}

struct Outcome {
  double rays = 0, seconds = 0;        // rays a display ray; the quicker of two runs
  double target_db = 0, limit_db = 0;  // seen, against the scene and against full sampling
};

constexpr int kFullRays = 512;

class Bench {
 public:
  explicit Bench(const Display& display)
      : display_(display),
        scene_(Rectangles()),
        eyes_(Eyes(display)),
        target_(Target(eyes_, scene_)),
        limit_(SeenBy(eyes_, StochasticRays(scene_, display, kFullRays), display)),
        lit_(LitEmitters(display)) {}

  double LimitDb() const { return PsnrOf(limit_, target_); }

  Outcome Measure(const Way& way) const {
    Outcome outcome;
    outcome.seconds = 1e9;
    LayerImages images;
    for (int run = 0; run < 2; ++run) {
      const Counted counted(scene_);
      const auto start = std::chrono::steady_clock::now();
      images = way.stochastic_rays > 0
                   ? StochasticRays(scene_, display_, way.stochastic_rays)
                   : Distribute(counted, display_, way.options, SilentProgress());
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      outcome.seconds = std::min(outcome.seconds, took.count());
      outcome.rays = way.stochastic_rays > 0 ? way.stochastic_rays : counted.rays() / lit_;
    }
    const std::vector<double> seen = SeenBy(eyes_, images, display_);
    outcome.target_db = PsnrOf(seen, target_);
    outcome.limit_db = PsnrOf(seen, limit_);
    return outcome;
  }

 private:
  Display display_;
  AnalyticScene scene_;
  std::vector<Eye> eyes_;
  std::vector<double> target_, limit_;
  double lit_;
};

Curve& CurveNamed(Figure& figure, const std::string& name) {
  for (Curve& curve : figure.curves) {
    if (curve.name == name) return curve;
  }
  figure.curves.push_back({name, {}, {}});
  return figure.curves.back();
}

}  // namespace

Experiment SpeedForAccuracy(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "trade";
  experiment.claim =
      "What the rays a display ray, the prefilter's kernel and its implementation cost, and what "
      "eyes get for it; quality best is at least as near to full sampling as balanced.";
  const Display display = quick ? CutTwoLayers(96, 48) : CutTwoLayers(240, 120);
  experiment.set_up = fmt::format(
      "Kernels as the program has them: beam, the exact box * box of openings and emitters; lens, "
      "the box of the paper; none. paper-two-layer cut to {} x {} px; textured rectangles from -20 "
      "to 20 mm before one another; eyes at 0, 32 and 54 mm; linear PSNR of what they see against "
      "the scene along 8 x 8 lines of sight a pixel, and against the same display fully sampled "
      "(Algorithm 2 with {} rays a beam). Seconds are wall times, the quicker of two runs, of a "
      "scene that costs almost nothing to ask. Presets: draft and balanced are beam with 1 node a "
      "step, best with 2.",
      display.width_px, display.height_px, kFullRays);
  const Bench bench(display);
  Figure target{"What eyes see, against the scene", "wall time, s", "PSNR, dB", {}, true};
  Figure limit{"What eyes see, against full sampling", "wall time, s", "PSNR, dB", {}, true};
  Table table{"All ways",
              {"way", "nodes a step", "samples a pixel", "rays a display ray", "s",
               "PSNR against the scene, dB", "against full sampling, dB"},
              {},
              {}};
  std::vector<double> presets;
  for (const Way& way : Ways(quick)) {
    const Outcome outcome = bench.Measure(way);
    const bool own = way.curve == "beam" && way.options.nodes_per_step <= 2;
    const bool best = own && way.options.nodes_per_step == 2;
    const bool lattice = way.stochastic_rays == 0;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    table.names.push_back(way.curve + (best ? " (best)" : own ? " (draft, balanced)" : ""));
    table.rows.push_back({lattice ? way.options.nodes_per_step : kNone,
                          lattice ? way.options.samples_per_pixel : kNone, outcome.rays,
                          outcome.seconds, outcome.target_db, outcome.limit_db});
    const auto add = [&](const std::string& name) {
      for (const auto& [figure, db] :
           {std::pair(&target, outcome.target_db), std::pair(&limit, outcome.limit_db)}) {
        Curve& curve = CurveNamed(*figure, name);
        curve.x.push_back(outcome.seconds);
        curve.y.push_back(db);
      }
    };
    add(way.curve);
    if (!own) continue;
    add(best ? "preset best" : "presets draft, balanced");
    presets.push_back(outcome.limit_db);
    const std::string at = best ? "best: " : "draft, balanced: ";
    experiment.rows.push_back(Reported(at + "rays a display ray", outcome.rays));
    experiment.rows.push_back(Reported(at + "PSNR against the scene, dB", outcome.target_db));
    experiment.rows.push_back(Reported(at + "PSNR against full sampling, dB", outcome.limit_db));
  }
  experiment.rows.push_back(Reported("full sampling: PSNR against the scene, dB", bench.LimitDb()));
  experiment.rows.push_back(
      AtLeast("best over balanced, against full sampling, dB", presets.at(1) - presets.at(0), 0));
  experiment.reason =
      "What is left against the scene is the display's own: two layers of 2-px pinholes before "
      "content of up to 0.8 cycles/mm. By rays, those of Algorithm 2, which follow a "
      "low-discrepancy sequence in each beam, are nearer to full sampling than the lattice of "
      "nodes from 16 a beam on, and farther below. But a scene that answers a single ray as "
      "cheaply as one of a whole bundle is not a capture: there a node is one picture for all "
      "layers and slots, which is what the lattice is for. The lens kernel is nearer to the scene "
      "than the pinholes' own beam, since before a layer it is narrower and so blurs less of what "
      "the display blurs once more.";
  experiment.figures = {std::move(target), std::move(limit)};
  experiment.tables.push_back(std::move(table));
  return experiment;
}

}  // namespace lamella::experiments
