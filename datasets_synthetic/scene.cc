#include "datasets_synthetic/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lamella {
namespace {

using Eigen::Vector3d;

std::vector<Eigen::AlignedBox3d> BoundsOf(const Scene& scene) {
  std::vector<Eigen::AlignedBox3d> bounds;
  bounds.reserve(scene.surfaces.size());
  for (const Surface& surface : scene.surfaces) bounds.push_back(BoundsOf(surface.shape));
  return bounds;
}

}  // namespace

SceneSource::SceneSource(Scene scene)
    : scene_(std::move(scene)),
      embree_(BoundsOf(scene_), [this](int index, const Ray& ray, double t_min, double t_max) {
        const Surface& surface = scene_.surfaces[static_cast<std::size_t>(index)];
        return Intersect(surface.shape, ray, t_min, t_max);
      }) {}

std::optional<SurfaceHit> SceneSource::FirstHit(const Ray& ray, double t_min) const {
  return embree_.FirstHit(ray, t_min);
}

// `cell`: side of the patch across the ray that it stands for, world units.
Rgb SceneSource::Shade(const SurfaceHit& hit, const Ray& ray, double cell) const {
  const Surface& surface = scene_.surfaces[static_cast<std::size_t>(hit.surface)];
  const Vector3d point = ray.origin + hit.t * ray.direction;
  Vector3d normal = NormalAt(surface.shape, point);
  if (normal.dot(ray.direction) > 0) normal = -normal;  // the side that is seen

  // Seen at an angle the patch grows by 1/cos; the limit keeps a grazing surface from going grey.
  const double cosine = -normal.dot(ray.direction) / ray.direction.norm();
  const double footprint = cell / std::max(cosine, 0.15);
  const Rgb reflectance = ColorAt(surface.texture, point - AnchorOf(surface.shape), footprint);

  const Lighting& lighting = scene_.lighting;
  const Vector3d to_lamp = lighting.lamp - point;
  const double facing = normal.dot(to_lamp) / to_lamp.norm();
  float light = lighting.ambient;
  if (facing > 0) {
    // From a little off the surface, so that it does not shade itself; up to the lamp at t = 1.
    const auto blocker = embree_.FirstHit({point, to_lamp}, 1e-6);
    if (!blocker || blocker->t >= 1) light += lighting.lamp_strength * static_cast<float>(facing);
  }
  return light * reflectance;
}

void SceneSource::Query(const RayBundle& bundle, const Rect& rectangle,
                        ImageSpan<RaySample> samples) const {
  const bool from_point = bundle.centre.w() != 0;
  const double t_min = from_point ? 0 : -std::numeric_limits<double>::infinity();
  const Vector3d normal = bundle.Normal();
  const double cell_on_plane = bundle.footprint * std::max(bundle.dx.norm(), bundle.dy.norm());
  for (int y = 0; y < rectangle.height; ++y) {
    for (int x = 0; x < rectangle.width; ++x) {
      const Ray ray = bundle.RayAt(rectangle.x + x + 0.5, rectangle.y + y + 0.5);
      RaySample& sample = samples(x, y);
      sample = RaySample{.color = scene_.background, .confidence = 1, .coverage = 1};
      const auto hit = embree_.FirstHit(ray, t_min);
      if (!hit) continue;
      // Rays of a point spread: at t = 1 they are on the plane.
      sample.color = Shade(*hit, ray, from_point ? hit->t * cell_on_plane : cell_on_plane);
      const Vector3d point = ray.origin + hit->t * ray.direction;
      sample.z = static_cast<float>((point - bundle.origin).dot(normal));
    }
  }
}

}  // namespace lamella
