// How fast the kernels are, as ratios: to the tests' plain reference loops and to the rate at which
// this machine copies memory, both measured in the same run and on the same threads' number.
//
//   x_reference    times faster than the reference, per pixel and label (or light path)
//   of_copy_rate   bytes of results a second over bytes that memcpy writes a second
#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "depth/plane_sweep.h"
#include "depth/sgm.h"
#include "depth/sweep_depth.h"
#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"
#include "tests/depth/synthetic.h"
#include "tests/reference/analytic_scene.h"
#include "tests/reference/plane_sweep_reference.h"
#include "tests/reference/sgm_reference.h"
#include "tests/reference/simulate_eye_reference.h"

namespace lamella {
namespace {

double SecondsOf(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double CopyBytesPerSecond() {
  static const double rate = [] {
    std::vector<char> from(std::size_t{64} << 20, 1), to(from.size());
    double best = 1e9;
    for (int i = 0; i < 5; ++i) {
      best = std::min(best, SecondsOf([&] {
                        std::memcpy(to.data(), from.data(), from.size());
                        benchmark::DoNotOptimize(to.data());
                      }));
    }
    return static_cast<double>(from.size()) / best;
  }();
  return rate;
}

// `items` of work and `bytes` of results an iteration; what the reference needs for an item.
void Report(benchmark::State& state, double items, double bytes, double reference_seconds) {
  const auto iterations = static_cast<double>(state.iterations());
  using Counter = benchmark::Counter;
  state.counters["items"] = Counter(items * iterations, Counter::kIsRate);
  state.counters["x_reference"] = Counter(items * iterations * reference_seconds, Counter::kIsRate);
  state.counters["of_copy_rate"] =
      Counter(bytes * iterations / CopyBytesPerSecond(), Counter::kIsRate);
}

Image<std::uint8_t> RandomLuma(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<std::uint8_t> luma(width, height);
  for (std::size_t i = 0; i < luma.size(); ++i) {
    luma.data()[i] = static_cast<std::uint8_t>(random());
  }
  return luma;
}

InverseDepthLabels Labels(int count) {
  InverseDepthLabels labels;
  for (int i = 0; i < count; ++i) labels.w.push_back(0.1 + 0.4 * i / count);
  return labels;
}

void SweepOfTwoSources(benchmark::State& state) {
  constexpr int kWidth = 768, kHeight = 512, kLabels = 128;
  const SweepImage reference(RandomLuma(kWidth, kHeight, 1)), left(RandomLuma(kWidth, kHeight, 2)),
      right(RandomLuma(kWidth, kHeight, 3));
  const Camera camera = synthetic::Pinhole(kWidth, kHeight, kWidth);
  std::vector<SweepSource> sources;
  for (const auto& [image, shift] : {std::pair(&left, -0.3), std::pair(&right, 0.3)}) {
    Rigid pose;
    pose.translation.x() = shift;
    const PictureMap map = MapPictures(camera, Rigid{}, camera, pose);
    sources.push_back({image, map.m, map.b});
  }
  const InverseDepthLabels labels = Labels(kLabels);
  constexpr int kSample = 2000;
  const double slow = SecondsOf([&] {
    int sum = 0;
    for (int i = 0; i < kSample; ++i) {
      sum +=
          reference::SweepCost(reference, sources, labels.w[static_cast<std::size_t>(i % kLabels)],
                               -3, 100 + i % 100, 100 + i / 100);
    }
    benchmark::DoNotOptimize(sum);
  });
  for (auto _ : state) benchmark::DoNotOptimize(SweepCost(reference, sources, labels).costs.get());
  constexpr double kItems = double{kWidth} * kHeight * kLabels;
  Report(state, kItems, kItems, slow / kSample);
}
BENCHMARK(SweepOfTwoSources)->UseRealTime()->Unit(benchmark::kMillisecond);

void SemiGlobalMatching(benchmark::State& state) {
  const auto volume = [](int width, int height, int labels) {
    std::mt19937 random(5);
    CostVolume cost(width, height, labels);
    for (std::size_t i = 0; i < cost.Bytes(); ++i) {
      cost.costs[i] = static_cast<std::uint8_t>(random() % CostVolume::kMaxCost);
    }
    return cost;
  };
  const CostVolume small = volume(96, 64, 64), cost = volume(768, 512, 128);
  const Image<std::uint8_t> small_guide = RandomLuma(96, 64, 1), guide = RandomLuma(768, 512, 1);
  const double slow = SecondsOf(
      [&] { benchmark::DoNotOptimize(reference::SumOfPaths(small, small_guide, {}).data()); });
  for (auto _ : state) {
    benchmark::DoNotOptimize(SemiGlobalMatch(cost, guide.span(), {}).label.data());
  }
  Report(state, 768.0 * 512 * 128, 768.0 * 512 * 128, slow / (96 * 64 * 64));
}
BENCHMARK(SemiGlobalMatching)->UseRealTime()->Unit(benchmark::kMillisecond);

Display PartOfTheDisplay(int width, int height) {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = width;
  display.height_px = height;
  return display;
}

LayerImages LayersOf(const Display& display) {
  AnalyticScene scene;
  Rectangle wall;
  wall.z = -5;
  wall.color = [](double x, double y) {
    return Rgb{static_cast<float>(0.5 + 0.01 * x), static_cast<float>(0.5 + 0.01 * y), 0.5F};
  };
  scene.rectangles = {wall};
  return Distribute(scene, display, LayersOptions(), SilentProgress());
}

Eye EyeOf(const Display& display) {
  Eye eye;
  eye.position = {0, 0, display.viewing_distance_mm};
  eye.pixel_mm = display.pitch_mm;
  eye.width = display.width_px;
  eye.height = display.height_px;
  eye.left_mm = -display.width_mm() / 2;
  eye.top_mm = display.height_mm() / 2;
  return eye;
}

void SimulatedEye(benchmark::State& state) {
  constexpr int kLines = 4;
  const Display small = PartOfTheDisplay(96, 48), display = PartOfTheDisplay(480, 270);
  const LayerImages small_layers = LayersOf(small), layers = LayersOf(display);
  const auto paths = [&](const Display& d) {  // per layer, over all slots
    return static_cast<double>(d.width_px) * d.height_px * kLines * kLines *
           static_cast<double>(d.layers.size());
  };
  const double slow = SecondsOf([&] {
    benchmark::DoNotOptimize(
        reference::SimulateEye(small_layers, small, EyeOf(small), kLines).color.data());
  });
  for (auto _ : state) {
    benchmark::DoNotOptimize(SimulateEye(layers, display, EyeOf(display), kLines).color.data());
  }
  Report(state, paths(display), 480.0 * 270 * sizeof(Rgb), slow / paths(small));
}
BENCHMARK(SimulatedEye)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lamella

BENCHMARK_MAIN();
