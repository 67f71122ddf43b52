// Rays a second of generated scenes, beside the fastest bare loop over Embree's packets that asks
// the same scene along the same rays in single precision. One thread; the loops take turns, so
// that what else the machine does meets all of them.
//
//   of_bare         rays a second over the bare loop's, best of all rounds
//   of_bare_median  the same, medians
//   ShadedMesh      Query, with shadows; of one colour and of noise
#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "datasets_synthetic/cameras.h"
#include "datasets_synthetic/embree_api-inl.h"
#include "datasets_synthetic/scene.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 1024, kHeight = 768;
constexpr double kRays = double{kWidth} * kHeight;

// 2 x 1000 x 750 triangles: hills before the camera, which fill the picture.
Scene Hills() {
  Mesh mesh = MeshOfHeightField({-4, -3, 8, 6, 1000, 750}, [](double x, double y) {
    return 0.3 * std::sin(3 * x) * std::cos(2.5 * y) + 0.02 * std::sin(40 * x + 30 * y);
  });
  Surface surface;
  surface.shape = std::make_shared<const Mesh>(std::move(mesh));
  return {{surface}, {}, {}};
}

RayBundle Bundle() {
  Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = 1.05 * kWidth;
  camera.cx = 0.5 * kWidth;
  camera.cy = 0.5 * kHeight;
  return BundleOfCamera(camera, LookAt({0.4, -0.7, 5}, {0, 0, 0}, {0, 1, 0}));
}

// Rays of a tile of 4 x 4 pixels as Embree takes them, from the camera's centre.
void BareDepth(const EmbreeMesh& mesh, const RayBundle& bundle, ImageSpan<float> t) {
  const FlushDenormals flush;
  const auto framed = [&](const Vector3d& v) { return (v / mesh.radius()).eval(); };
  const Eigen::Vector3f origin = framed(bundle.centre.head<3>() - mesh.centre()).cast<float>();
  const Eigen::Vector3f first =
      framed(bundle.PlanePoint(0.5, 0.5) - bundle.centre.head<3>()).cast<float>();
  const Eigen::Vector3f dx = framed(bundle.dx).cast<float>(), dy = framed(bundle.dy).cast<float>();
  alignas(64) int valid[16];
  std::fill(valid, valid + 16, -1);
  RTCRayHit16 rays;
  for (int i = 0; i < 16; ++i) {
    rays.ray.org_x[i] = origin.x();
    rays.ray.org_y[i] = origin.y();
    rays.ray.org_z[i] = origin.z();
    rays.ray.tnear[i] = 0;
    rays.ray.time[i] = 0;
    rays.ray.mask[i] = ~0U;
    rays.ray.id[i] = 0;
    rays.ray.flags[i] = 0;
  }
  EmbreeContext context;
  for (int y = 0; y < kHeight; y += 4) {
    for (int x = 0; x < kWidth; x += 4) {
      for (int i = 0; i < 16; ++i) {
        const int column = x + i % 4, row = y + i / 4;
        const auto u = static_cast<float>(column), v = static_cast<float>(row);
        rays.ray.dir_x[i] = first.x() + u * dx.x() + v * dy.x();
        rays.ray.dir_y[i] = first.y() + u * dx.y() + v * dy.y();
        rays.ray.dir_z[i] = first.z() + u * dx.z() + v * dy.z();
        rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
        rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      }
      Intersect16(valid, mesh.scene(), &context, &rays);
      for (int i = 0; i < 16; ++i) t(x + i % 4, y + i / 4) = rays.ray.tfar[i];
    }
  }
}

// Of processor time: other programs take turns with this one, too.
double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Loop {
  std::function<void()> run;
  std::vector<double> seconds = {};

  void Time() {
    const double start = ThreadSeconds();
    run();
    seconds.push_back(ThreadSeconds() - start);
  }
  double Best() const { return *std::min_element(seconds.begin(), seconds.end()); }
  double Median() {
    const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
    std::nth_element(seconds.begin(), middle, seconds.end());
    return *middle;
  }
};

// Neither what a texture costs: noise is bare arithmetic.
Scene PlainHills() {
  Scene scene = Hills();
  scene.surfaces[0].texture = Texture{.pattern = Texture::Pattern::kPlain};
  return scene;
}

void Report(benchmark::State& state, Loop* bare, Loop* ours) {
  state.counters["bare_rays"] = kRays / bare->Best();
  state.counters["rays"] = kRays / ours->Best();
  state.counters["of_bare"] = bare->Best() / ours->Best();
  state.counters["of_bare_median"] = bare->Median() / ours->Median();
}

void DepthOfAMesh(benchmark::State& state) {
  const SceneSource scene(Hills());
  const RayBundle bundle = Bundle();
  Image<float> t(kWidth, kHeight), bare_t(kWidth, kHeight);
  Loop bare{[&] { BareDepth(*scene.embree().MeshOf(0), bundle, bare_t.span()); }};
  Loop depth{[&] { scene.QueryDepth(bundle, {0, 0, kWidth, kHeight}, t.span()); }};
  for (auto _ : state) {
    bare.Time();
    depth.Time();
  }
  double worst = 0;  // the loops ask the same: in single precision they agree
  for (std::size_t i = 0; i < t.size(); ++i) {
    worst = std::max(
        worst,
        std::abs(static_cast<double>(t.data()[i]) / static_cast<double>(bare_t.data()[i]) - 1));
  }
  if (!(worst < 1e-3)) state.SkipWithError("the bare loop sees something else");
  Report(state, &bare, &depth);
}
BENCHMARK(DepthOfAMesh)->Iterations(30)->UseRealTime()->Unit(benchmark::kMillisecond);

void ShadedMesh(benchmark::State& state) {
  const SceneSource scene(state.range(0) == 0 ? PlainHills() : Hills());
  const RayBundle bundle = Bundle();
  Image<float> bare_t(kWidth, kHeight);
  Image<RaySample> samples(kWidth, kHeight);
  Loop bare{[&] { BareDepth(*scene.embree().MeshOf(0), bundle, bare_t.span()); }};
  const ThreadLimit one(1);  // as the bare loop
  Loop shaded{[&] { scene.Query(bundle, {0, 0, kWidth, kHeight}, samples.span()); }};
  for (auto _ : state) {
    bare.Time();
    shaded.Time();
  }
  Report(state, &bare, &shaded);
}
BENCHMARK(ShadedMesh)
    ->ArgName("noise")
    ->Arg(0)
    ->Arg(1)
    ->Iterations(5)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lamella

BENCHMARK_MAIN();
