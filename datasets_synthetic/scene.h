// A generated scene: textured surfaces under fixed light, as a RaySource with exact depth.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "datasets_synthetic/embree_scene.h"
#include "datasets_synthetic/image_texture.h"
#include "datasets_synthetic/shapes.h"
#include "datasets_synthetic/textures.h"
#include "lightfield/ray_source.h"

namespace lamella {

// A white highlight of the lamp that moves with the view (Phong 1975): strength (r . v)^exponent
// times the lamp's, r its mirrored direction, v the viewer's.
struct Gloss {
  double strength = 0;
  double exponent = 40;
};

struct Surface {
  Shape shape;
  std::variant<Texture, ImageTexture> texture = {};
  Gloss gloss = {};
};

// Diffuse light, so that a point looks the same from everywhere but for its gloss.
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
  // InputError where a mesh does not fit together, MachineError where Embree can't be set up.
  explicit SceneSource(Scene scene);
  SceneSource(const SceneSource&) = delete;  // embree_ looks at the surfaces
  SceneSource& operator=(const SceneSource&) = delete;

  // Parallel over bands of rows.
  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override;

  // Where on each ray its first surface lies: t of origin + t direction, +inf where there is none.
  // Of a camera's bundle that is depth along the optical axis, in single precision throughout
  // (RaySample::z, which counts from the plane, keeps fewer digits of what is very near).
  void QueryDepth(const RayBundle& bundle, const Rect& rectangle, ImageSpan<float> t) const;

  // The first surface on the ray at t > t_min, in double precision.
  std::optional<SurfaceHit> FirstHit(const Ray& ray, double t_min = 0) const;

  const Scene& scene() const { return scene_; }
  const EmbreeScene& embree() const { return embree_; }

 private:
  void QueryBand(const RayBundle& bundle, const Rect& rectangle,
                 ImageSpan<RaySample> samples) const;

  Scene scene_;
  EmbreeScene embree_;
};

}  // namespace lamella
