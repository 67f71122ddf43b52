#include "datasets_synthetic/photograph.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr int kTileRows = 16;

// Differences between neighbours that only an edge explains: a jump of depth, or of light that
// band-limited textures don't make within a pixel.
bool IsEdge(const RaySample& a, const RaySample& b, float depth_a, float depth_b) {
  const float nearer = std::min(depth_a, depth_b), farther = std::max(depth_a, depth_b);
  if (!(farther - nearer <= 0.01F * nearer)) return std::isfinite(nearer);
  const float difference =
      std::max({std::abs(a.color.r - b.color.r), std::abs(a.color.g - b.color.g),
                std::abs(a.color.b - b.color.b)});
  const float level = std::max({a.color.g, b.color.g, 0.05F});
  return difference > 0.25F * level;
}

bool TouchesEdge(const Image<RaySample>& samples, const Image<float>& depth, int x, int y) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int u = std::clamp(x + dx, 0, samples.width() - 1);
      const int v = std::clamp(y + dy, 0, samples.height() - 1);
      if (IsEdge(samples(x, y), samples(u, v), depth(x, y), depth(u, v))) return true;
    }
  }
  return false;
}

// The mean over the pixel's area from n x n rays.
Rgb Supersampled(const RaySource& scene, const RayBundle& fine, int x, int y, int n,
                 Image<RaySample>* buffer) {
  scene.Query(fine, {x * n, y * n, n, n}, buffer->span());
  Rgb sum;
  for (std::size_t i = 0; i < buffer->size(); ++i) sum += buffer->data()[i].color;
  return (1.0F / static_cast<float>(buffer->size())) * sum;
}

}  // namespace

Photograph TakePhotograph(const SceneSource& scene, const Camera& camera,
                          const Rigid& camera_from_world, int supersampling) {
  const RayBundle bundle = BundleOfCamera(camera, camera_from_world);
  const int width = camera.width, height = camera.height;
  Image<RaySample> samples(width, height);
  Photograph photograph{Image<Rgb>(width, height), Image<float>(width, height)};
  ParallelFor(0, height, kTileRows, [&](std::int64_t first, std::int64_t last) {
    const Rect rows{0, static_cast<int>(first), width, static_cast<int>(last - first)};
    scene.Query(bundle, rows, samples.span().Sub(rows));
    for (int y = rows.y; y < rows.y + rows.height; ++y) {
      for (int x = 0; x < width; ++x) photograph.depth(x, y) = 1 - samples(x, y).z;
    }
  });

  const int n = std::max(1, supersampling);
  RayBundle fine = bundle;
  fine.dx /= n;
  fine.dy /= n;
  fine.width *= n;
  fine.height *= n;
  fine.footprint = n;  // textures stay limited to the pixel's band
  ParallelFor(0, height, kTileRows, [&](std::int64_t first, std::int64_t last) {
    Image<RaySample> buffer(n, n);
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width; ++x) {
        photograph.color(x, y) = n > 1 && TouchesEdge(samples, photograph.depth, x, y)
                                     ? Supersampled(scene, fine, x, y, n, &buffer)
                                     : samples(x, y).color;
      }
    }
  });
  return photograph;
}

}  // namespace lamella
