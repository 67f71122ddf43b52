// "What is seen along these rays?": the one question to a scene, whatever it is: a capture with
// depth, a synthetic scene, a light field on a lattice.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/rigid.h"

namespace lamella {

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  // away from the viewer, into the scene
};

// A grid of rays through one point (a camera, an eye, a node of the eye plane), or of one
// direction. Ray (i, j), 0 <= i < width, 0 <= j < height, passes the plane point
//   P(i, j) = origin + (i + 0.5) dx + (j + 0.5) dy.
// A point bundle (centre.w = 1) looks from the centre through P and beyond; a direction bundle
// (centre.w = 0) has centre.head<3>() pointing from the scene towards the viewer.
// Rays are lines that are followed from the viewer's side: the first surface is seen, in front of
// the plane (between it and the viewer) as well as behind it.
// (dx, dy, viewing direction) is right-handed: x right, y down, z away from the viewer.
struct RayBundle {
  Eigen::Vector4d centre{0, 0, 0, 1};
  Eigen::Vector3d origin{0, 0, 0}, dx{1, 0, 0}, dy{0, 1, 0};
  int width = 0, height = 0;
  double footprint = 1;  // side of a ray's cell in plane pixels (|dx|): 1 = the grid's own spacing

  Eigen::Vector3d PlanePoint(double i, double j) const { return origin + i * dx + j * dy; }
  // The plane's unit normal, towards the viewer.
  Eigen::Vector3d Normal() const { return dy.cross(dx).normalized(); }
  Ray RayAt(double i, double j) const {
    const Eigen::Vector3d p = PlanePoint(i, j);
    if (centre.w() == 0) return {p, -centre.head<3>()};
    return {centre.head<3>(), p - centre.head<3>()};
  }
};

struct RaySample {
  Rgb color;  // linear
  // Signed distance of the seen point from the bundle's plane along Normal(), i.e. positive towards
  // the viewer; -inf for the background at infinity.
  float z = -std::numeric_limits<float>::infinity();
  float confidence = 0;  // [0, 1]
  float coverage = 0;    // 1 seen, 0 unknown; between: share of the ray's footprint seen
};

class RaySource {
 public:
  virtual ~RaySource() = default;
  // Fills `samples` (rectangle.width x rectangle.height) with rays (rectangle.x + i, rectangle.y +
  // j) of the bundle. A rectangle never changes a value: what is decided from neighbours or for
  // holes is decided per whole bundle. Safe to call from many threads.
  virtual void Query(const RayBundle& bundle, const Rect& rectangle,
                     ImageSpan<RaySample> samples) const = 0;
  // What a query of so many rays allocates at most, meanwhile and for queries to come; 0: hardly
  // anything. Not while others ask.
  virtual double QueryBytes(int /*width*/, int /*height*/) const { return 0; }
};

// The rays of a pinhole camera's pixels: plane at depth 1 in front of it, so that
// depth along the optical axis = 1 - z.
inline RayBundle BundleOfCamera(const Camera& camera, const Rigid& camera_from_world) {
  const Rigid world_from_camera = Inverse(camera_from_world);
  RayBundle bundle;
  bundle.centre << world_from_camera.translation, 1;
  bundle.origin =
      world_from_camera * Eigen::Vector3d(-camera.cx / camera.fx, -camera.cy / camera.fy, 1);
  bundle.dx = world_from_camera.rotation * Eigen::Vector3d(1 / camera.fx, 0, 0);
  bundle.dy = world_from_camera.rotation * Eigen::Vector3d(0, 1 / camera.fy, 0);
  bundle.width = camera.width;
  bundle.height = camera.height;
  return bundle;
}

}  // namespace lamella
