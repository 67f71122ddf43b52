// Photographs of a generated scene, with their exact depth.
#pragma once

#include "datasets_synthetic/scene.h"
#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/rigid.h"

namespace lamella {

struct Photograph {
  Image<Rgb> color;  // linear; each pixel the mean over its area
  Image<float>
      depth;  // along the optical axis, of the ray through the pixel's centre; +inf: background
};

// `camera` is a pinhole. Textures carry no detail finer than a pixel, so one ray a pixel suffices
// except where surfaces or shadows meet: there supersampling x supersampling rays are taken.
// Does not depend on the number of threads.
Photograph TakePhotograph(const SceneSource& scene, const Camera& camera,
                          const Rigid& camera_from_world, int supersampling);

}  // namespace lamella
