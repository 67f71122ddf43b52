#include "datasets_synthetic/photograph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPhotographRows = 16;

struct Sampling {
  int rays_per_pixel = 1;   // and axis
  double footprint_px = 1;  // side of the patch that textures are limited to
  Vector2d shift{0, 0};     // of the rays on the sensor, px
  Vector2d lens{0, 0};      // where they pass the lens, in the camera's axes
  double sharp_at = 1;      // depth at which the whole lens sees one point
};

// The rays of a camera's pixels, through one point of its lens.
class CameraRays {
 public:
  CameraRays(const SceneSource& scene, const Camera& camera, const Rigid& camera_from_world,
             const Sampling& sampling)
      : scene_(scene),
        camera_(camera),
        sampling_(sampling),
        world_from_camera_(Inverse(camera_from_world)),
        bundle_(BundleOfCamera(camera, camera_from_world)) {
    const Vector3d pinhole = world_from_camera_.translation;
    if (sampling.sharp_at != 1) {
      bundle_.origin = pinhole + sampling.sharp_at * (bundle_.origin - pinhole);
      bundle_.dx *= sampling.sharp_at;
      bundle_.dy *= sampling.sharp_at;
    }
    if (!sampling.shift.isZero(0)) {
      bundle_.origin += sampling.shift.x() * bundle_.dx + sampling.shift.y() * bundle_.dy;
    }
    if (!sampling.lens.isZero(0)) bundle_.centre.head<3>() = OnLens();
    const int n = sampling.rays_per_pixel;
    if (n > 1) {
      bundle_.dx /= n;
      bundle_.dy /= n;
      bundle_.width *= n;
      bundle_.height *= n;
    }
    bundle_.footprint = n * sampling.footprint_px;
  }

  // `rectangle` counts rays. Coverage 0: no ray is bent to that pixel.
  void Query(const Rect& rectangle, ImageSpan<RaySample> samples) const {
    if (camera_.model == CameraModel::kPinhole) return scene_.Query(bundle_, rectangle, samples);
    for (int y = 0; y < rectangle.height; ++y) {
      for (int x = 0; x < rectangle.width; ++x) {
        samples(x, y) = RaySample{};
        const std::optional<RayBundle> ray = Bent(rectangle.x + x, rectangle.y + y);
        if (ray) scene_.Query(*ray, {0, 0, 1, 1}, {&samples(x, y), 1, 1, 1});
      }
    }
  }
  // Along the optical axis, where all of the lens is one point.
  void QueryDepth(const Rect& rectangle, ImageSpan<float> depth) const {
    if (camera_.model == CameraModel::kPinhole) return scene_.QueryDepth(bundle_, rectangle, depth);
    for (int y = 0; y < rectangle.height; ++y) {
      for (int x = 0; x < rectangle.width; ++x) {
        depth(x, y) = 0;
        const std::optional<RayBundle> ray = Bent(rectangle.x + x, rectangle.y + y);
        if (ray) scene_.QueryDepth(*ray, {0, 0, 1, 1}, {&depth(x, y), 1, 1, 1});
      }
    }
  }

 private:
  Vector3d OnLens() const {
    return world_from_camera_ * Vector3d(sampling_.lens.x(), sampling_.lens.y(), 0);
  }
  // Where the camera bends rays each one is a bundle of its own.
  std::optional<RayBundle> Bent(int x, int y) const {
    const double n = sampling_.rays_per_pixel;
    const Vector2d pixel = Vector2d((x + 0.5) / n, (y + 0.5) / n) + sampling_.shift;
    Eigen::Matrix<double, 3, 2> slope;
    const std::optional<Vector3d> direction = Unproject(camera_, pixel, &slope);
    if (!direction) return std::nullopt;
    RayBundle ray = bundle_;
    ray.width = ray.height = 1;
    ray.dx = world_from_camera_.rotation * (sampling_.sharp_at / n * slope.col(0));
    ray.dy = world_from_camera_.rotation * (sampling_.sharp_at / n * slope.col(1));
    ray.origin = world_from_camera_ * (sampling_.sharp_at * *direction) - 0.5 * (ray.dx + ray.dy);
    return ray;
  }

  const SceneSource& scene_;
  const Camera& camera_;
  Sampling sampling_;
  Rigid world_from_camera_;
  RayBundle bundle_;
};

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
Rgb Supersampled(const CameraRays& fine, int x, int y, int n, Image<RaySample>* buffer) {
  fine.Query({x * n, y * n, n, n}, buffer->span());
  Rgb sum;
  for (std::size_t i = 0; i < buffer->size(); ++i) sum += buffer->data()[i].color;
  return (1.0F / static_cast<float>(buffer->size())) * sum;
}

// One ray a pixel, and the depth along it.
Image<RaySample> Pinhole(const CameraRays& rays, const Camera& camera, Image<float>* depth) {
  Image<RaySample> samples(camera.width, camera.height);
  *depth = Image<float>(camera.width, camera.height);
  ParallelFor(0, camera.height, kPhotographRows, [&](std::int64_t first, std::int64_t last) {
    const Rect rows{0, static_cast<int>(first), camera.width, static_cast<int>(last - first)};
    rays.Query(rows, samples.span().Sub(rows));
    rays.QueryDepth(rows, depth->span().Sub(rows));
  });
  return samples;
}

// The bits of i mirrored at the point, over [0, 1).
double Moment(int i) {
  double value = 0, bit = 0.5;
  for (unsigned rest = static_cast<unsigned>(i); rest != 0; rest >>= 1U, bit *= 0.5) {
    value += (rest & 1U) * bit;
  }
  return value;
}

// Sample `i` of `count`: places on the lens along a spiral of equal areas, and within every turn of
// it places within the pixel and moments that are spread evenly, too.
Sampling SampleOf(const Shutter& shutter, int i, double* time) {
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  const double radius = 0.5 * shutter.aperture * std::sqrt((i + 0.5) / shutter.samples);
  Sampling sampling;
  sampling.lens = radius * Vector2d(std::cos(i * golden), std::sin(i * golden));
  sampling.sharp_at = shutter.aperture > 0 ? shutter.focus_distance : 1;
  // The additive sequence of the plastic number (Roberts, "The unreasonable effectiveness of
  // quasirandom sequences", 2018).
  const auto part = [&](double step) { return std::fmod(0.5 + step * i, 1.0) - 0.5; };
  sampling.shift = {part(0.7548776662466927), part(0.5698402909980532)};
  sampling.footprint_px = 0.5;  // the samples average over the rest of the pixel
  *time = Moment(i) + 0.5 / shutter.samples - 0.5;
  return sampling;
}

}  // namespace

Photograph TakePhotograph(const SceneSource& scene, const Camera& camera,
                          const Rigid& camera_from_world, int supersampling) {
  Photograph photograph;
  const Image<RaySample> samples =
      Pinhole(CameraRays(scene, camera, camera_from_world, {}), camera, &photograph.depth);
  const int n = std::max(1, supersampling);
  const CameraRays fine(scene, camera, camera_from_world, {.rays_per_pixel = n});
  photograph.color = Image<Rgb>(camera.width, camera.height);
  ParallelFor(0, camera.height, kPhotographRows, [&](std::int64_t first, std::int64_t last) {
    Image<RaySample> buffer(n, n);
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        photograph.color(x, y) = n > 1 && TouchesEdge(samples, photograph.depth, x, y)
                                     ? Supersampled(fine, x, y, n, &buffer)
                                     : samples(x, y).color;
      }
    }
  });
  return photograph;
}

Photograph TakePhotograph(const SceneSource& scene, const Camera& camera,
                          const Rigid& camera_from_world, const Shutter& shutter,
                          int supersampling) {
  if (shutter.IsInstant()) return TakePhotograph(scene, camera, camera_from_world, supersampling);
  Photograph photograph;
  Pinhole(CameraRays(scene, camera, camera_from_world, {}), camera, &photograph.depth);
  photograph.color = Image<Rgb>(camera.width, camera.height);
  const Rigid world_from_middle = Inverse(camera_from_world);
  const float weight = 1.0F / static_cast<float>(shutter.samples);
  for (int i = 0; i < shutter.samples; ++i) {
    double time = 0;
    const Sampling sampling = SampleOf(shutter, i, &time);
    const Vector3d turn = time * shutter.turn;
    const Rigid middle_from_now{
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized())),
        time * shutter.motion};
    const CameraRays rays(scene, camera, Inverse(world_from_middle * middle_from_now), sampling);
    ParallelFor(0, camera.height, kPhotographRows, [&](std::int64_t first, std::int64_t last) {
      const Rect rows{0, static_cast<int>(first), camera.width, static_cast<int>(last - first)};
      Image<RaySample> samples(rows.width, rows.height);
      rays.Query(rows, samples.span());
      Rgb* sum = photograph.color.row(rows.y);
      for (std::size_t k = 0; k < samples.size(); ++k) sum[k] += weight * samples.data()[k].color;
    });
  }
  return photograph;
}

}  // namespace lamella
