// Photographs of a generated scene, with their exact depth.
#pragma once

#include <Eigen/Core>

#include "datasets_synthetic/scene.h"
#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/rigid.h"

namespace lamella {

struct Photograph {
  Image<Rgb> color;  // linear; each pixel the mean over its area
  // Along the optical axis, of the ray through the pixel's centre; +inf: background, 0: no ray is
  // bent to this pixel.
  Image<float> depth;
};

// A thin lens and an exposure that lasts. The camera's pose is that of the middle of the exposure;
// over it the camera moves evenly by `motion` and turns by `turn`.
struct Shutter {
  double aperture = 0;                               // diameter of the lens, world units
  double focus_distance = 1;                         // along the axis, world units
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();  // world units, in the camera's axes
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();    // axis times angle in radians, likewise
  int samples = 64;                                  // rays per pixel

  bool IsInstant() const { return aperture == 0 && motion.isZero(0) && turn.isZero(0); }
};

// Textures carry no detail finer than a pixel, so one ray a pixel suffices except where surfaces or
// shadows meet: there supersampling x supersampling rays are taken. Any camera model; rays of a
// distorted pixel are those of lightfield/camera.h. Does not depend on the number of threads.
Photograph TakePhotograph(const SceneSource& scene, const Camera& camera,
                          const Rigid& camera_from_world, int supersampling);

// The same through a lens and with a motion that blur: each of the shutter's samples is a place on
// the lens, a moment and a place within the pixel. A point at depth z is a disk of
// aperture f |1/z - 1/focus_distance| px. Depth is that of the pinhole in the middle of the
// exposure. An instant pinhole is TakePhotograph above.
Photograph TakePhotograph(const SceneSource& scene, const Camera& camera,
                          const Rigid& camera_from_world, const Shutter& shutter,
                          int supersampling);

}  // namespace lamella
