// Which of many surfaces does a ray meet first? Embree finds the candidates in single precision,
// the surfaces' own equations decide in double precision.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "lightfield/ray_source.h"

namespace lamella {

// The smallest t in (t_min, t_max) where ray.origin + t ray.direction lies on surface `index`;
// nothing where there is none. Called from many threads.
using SurfaceIntersection =
    std::function<std::optional<double>(int index, const Ray& ray, double t_min, double t_max)>;

struct SurfaceHit {
  int surface = 0;
  double t = 0;  // along the ray's direction, in its units
};

class EmbreeScene {
 public:
  // Surface i lies within bounds[i], which must be finite and not empty. MachineError where Embree
  // can't be set up.
  EmbreeScene(std::vector<Eigen::AlignedBox3d> bounds, SurfaceIntersection intersection);
  ~EmbreeScene();
  EmbreeScene(EmbreeScene&&) noexcept;
  EmbreeScene& operator=(EmbreeScene&&) noexcept;

  // The first surface with t > t_min (which may be -infinity: from the viewer's side of a parallel
  // projection). Of surfaces at one t the first in the list is met, so the answer never depends on
  // how Embree built its tree. Safe to call from many threads; the caller's floating-point modes
  // are kept.
  std::optional<SurfaceHit> FirstHit(const Ray& ray, double t_min) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lamella
