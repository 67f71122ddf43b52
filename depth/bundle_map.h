// Projective maps between the rays of a bundle and the pixels of a pinhole view.
//
// A scene point on ray (u, v) of a bundle (plane coordinates: u = i + 0.5 at ray i) is
//   X ~ (P(u, v), 1) + k centre        [homogeneous]
// for a number k that grows towards the viewer: 0 on the plane, -1 at infinity of a point bundle.
// The *nearness* n is 1 + k for a point bundle (0 at infinity, as an inverse depth is) and k for a
// direction bundle. (u, v, n) and a view's (x, y, 1/Z) are related by a 4x4 matrix in both
// directions, and on planes of the scene n is linear in (u, v), as 1/Z is in (x, y).
#pragma once

#include <Eigen/Core>

#include "lightfield/camera.h"
#include "lightfield/ray_source.h"
#include "lightfield/rigid.h"

namespace lamella {

// X_h m = matrix * (u, v, 1, n), m > 0 in front of the viewer. Singular where the plane holds the
// centre or has no area.
Eigen::Matrix4d WorldFromBundle(const RayBundle& bundle);

// The same for nearnesses that count from `zero`: a scene that is thin beside its distance from the
// viewer needs the digits of a float for its own extent.
Eigen::Matrix4d CountedFrom(double zero, const Eigen::Matrix4d& world_from_bundle);

// m (x, y, 1, 1/Z) = matrix * X_h, m > 0 in front of the camera.
Eigen::Matrix4d ViewFromWorld(const Camera& camera, const Rigid& camera_from_world);

// Signed distance from the bundle's plane towards the viewer, -inf at infinity: h - h / n for a
// point bundle whose centre is h before the plane, the direction's part along the normal times n
// for a direction bundle.
class DistanceFromNearness {
 public:
  DistanceFromNearness(const RayBundle& bundle, double zero);
  float operator()(float n) const;

 private:
  bool is_point_;
  double scale_, zero_;
};

// A 4x4 map around one of its points, in float: m (x, y, 1, q) = M (a, b, 1, c). Offsets from the
// point keep their own 1e-7, whatever the size of the coordinates.
struct LocalMap {
  LocalMap(const Eigen::Matrix4d& map, double at_a, double at_b, double at_c);

  // Where (at + (da, db, dc)) goes; `c` is the whole third coordinate, at_c + dc.
  // m <= 0: behind.
  struct Out {
    float x, y, q, m;
  };
  Out operator()(float da, float db, float dc, float c) const {
    const float m = m0 + ma * da + mb * db + mc * dc;
    const float inverse = 1.0F / m;
    return {x0 + (x_0 + xa * da + xb * db + xc * dc) * inverse,
            y0 + (y_0 + ya * da + yb * db + yc * dc) * inverse,
            (q_0 + qa * da + qb * db + qc * c) * inverse, m};
  }

  float x0, y0;    // where the point goes
  float x_0, y_0;  // 0 where it is in front
  float xa, xb, xc, ya, yb, yc, m0, ma, mb, mc, q_0, qa, qb, qc;
};

}  // namespace lamella
