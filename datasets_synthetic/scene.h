// A generated scene: textured surfaces under fixed light, as a RaySource with exact depth.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "datasets_synthetic/embree_scene.h"
#include "datasets_synthetic/shapes.h"
#include "datasets_synthetic/textures.h"
#include "lightfield/ray_source.h"

namespace lamella {

struct Surface {
  Shape shape;
  Texture texture;
};

// Diffuse light only, so that a point looks the same from everywhere.
struct Lighting {
  Eigen::Vector3d lamp{0, 10, 10};  // a point far away or near, white
  float lamp_strength = 0.7F;       // irradiance / pi of a surface that faces it
  float ambient = 0.3F;             // from everywhere, not shadowed
};

struct Scene {
  std::vector<Surface> surfaces;
  Lighting lighting;
  Rgb background;  // at infinity
};

// Answers with coverage 1 and confidence 1 everywhere: a generated scene knows all of itself.
class SceneSource : public RaySource {
 public:
  explicit SceneSource(Scene scene);
  SceneSource(const SceneSource&) = delete;  // embree_ asks back for the surfaces
  SceneSource& operator=(const SceneSource&) = delete;

  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override;

  // The first surface on the ray at t > t_min, in double precision.
  std::optional<SurfaceHit> FirstHit(const Ray& ray, double t_min = 0) const;

  const Scene& scene() const { return scene_; }

 private:
  Rgb Shade(const SurfaceHit& hit, const Ray& ray, double cell) const;

  Scene scene_;
  EmbreeScene embree_;
};

}  // namespace lamella
