// The model of a photograph of a panel: from a panel's pixel to the direction in which a camera
// sees it, and from there to the photograph's pixel, each as one formula for values (T = double)
// and for derivatives (T = ceres::Jet). calibration.md section 1; lengths
// in mm. lightfield/panel_rays.h goes the other way, along a line of sight to the panel's pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <Eigen/Core>

#include "lightfield/calibration.h"

namespace lamella::model {

template <class T>
using Vec2 = Eigen::Matrix<T, 2, 1>;
template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3 = Eigen::Matrix<T, 3, 3>;

// A number without its derivatives.
template <class T>
double ValueOf(const T& x) {
  if constexpr (std::is_floating_point_v<T>) {
    return x;
  } else {
    return x.a;
  }
}

// fx, fy, cx, cy in px, then Brown's k1, k2, p1, p2, k3 (as CameraModel::kBrown).
constexpr int kCameraSize = 9;
template <class T>
Vec2<T> Project(const Eigen::Matrix<T, kCameraSize, 1>& c, const Vec3<T>& point) {
  const T inverse = 1.0 / point.z();
  const T x = point.x() * inverse, y = point.y() * inverse;
  const T xx = x * x, yy = y * y, xy = x * y, rr = xx + yy;
  const T radial = 1.0 + rr * (c(4) + rr * (c(5) + rr * c(8)));
  const T u = x * radial + 2.0 * c(6) * xy + c(7) * (rr + 2.0 * xx);
  const T v = y * radial + c(6) * (rr + 2.0 * yy) + 2.0 * c(7) * xy;
  return {c(0) * u + c(2), c(1) * v + c(3)};
}

// The rotation by the vector r (Rodrigues), with its limit at 0.
template <class T>
Mat3<T> Rotation(const Vec3<T>& r) {
  using std::cos, std::sin, std::sqrt;
  const T angle2 = r(0) * r(0) + r(1) * r(1) + r(2) * r(2);
  T a = 1.0 - angle2 / 6.0, b = 0.5 - angle2 / 24.0;  // sin(t)/t and (1 - cos(t))/t^2
  if (ValueOf(angle2) > 1e-6) {
    const T angle = sqrt(angle2);
    a = sin(angle) / angle;
    b = (1.0 - cos(angle)) / angle2;
  }
  Mat3<T> m;
  m << 1.0 - b * (r(1) * r(1) + r(2) * r(2)), b * r(0) * r(1) - a * r(2),
      b * r(0) * r(2) + a * r(1), b * r(0) * r(1) + a * r(2), 1.0 - b * (r(0) * r(0) + r(2) * r(2)),
      b * r(1) * r(2) - a * r(0), b * r(0) * r(2) - a * r(1), b * r(1) * r(2) + a * r(0),
      1.0 - b * (r(0) * r(0) + r(1) * r(1));
  return m;
}

// A pixel in its panel's frame; shape is s, a, k and the bow in mm (lightfield/calibration.h). The
// pincushion may be a number or an unknown (double or T).
template <class T, class Pincushion>
Vec3<T> PanelPoint(const PanelCalibration& panel, const Eigen::Matrix<T, 4, 1>& shape,
                   const Pincushion& pincushion, const Eigen::Vector2d& pixel) {
  const double p = panel.pitch_mm, R = panel.HalfDiagonalMm();
  const double u = p * (pixel.x() - panel.width_px / 2.0);
  const double v = p * (panel.height_px / 2.0 - pixel.y());
  const T scale = 1.0 + shape(0);
  T y = v * (scale * (1.0 - shape(1)));
  T x = u * (scale * (1.0 + shape(1))) + shape(2) * y;
  // An unknown has a slope at 0, too.
  if (!std::is_floating_point_v<Pincushion> || ValueOf(pincushion) != 0) {
    const T radial = 1.0 + pincushion / (R * R) * (x * x + y * y);
    x = x * radial;
    y = y * radial;
  }
  const T z = shape(3) * (x * x + y * y) / (R * R);
  return {panel.mirror_x ? T(-x) : x, y, z};
}

// Where light from a point at `depth` behind an interface, at sideways distance L, crosses on its
// way to an eye at height d: the distance r from the eye's foot with
//   f(r) = r/sqrt(r^2 + d^2) - n w/sqrt(w^2 + depth^2) = 0,  w = L - r
// Newton's steps run on plain numbers; one more with frozen slope and f of type T then gives exact
// first derivatives (implicit function theorem) without differentiating the loop.
template <class T>
T RefractionCrossing(const T& d, const T& depth, const T& L, const T& index) {
  using std::sqrt;
  const double d0 = ValueOf(d), z0 = ValueOf(depth), L0 = ValueOf(L), n0 = ValueOf(index);
  double r = L0 * d0 / (d0 + z0 / n0), slope = 1;
  for (int i = 0; i < 6; ++i) {
    const double w = L0 - r, eye = std::sqrt(r * r + d0 * d0), deep = std::sqrt(w * w + z0 * z0);
    slope = d0 * d0 / (eye * eye * eye) + n0 * z0 * z0 / (deep * deep * deep);
    const double step = (r / eye - n0 * w / deep) / slope;
    r -= step;
    if (std::abs(step) < 1e-14 * L0) break;
  }
  const T w = L - r;
  const T f = r / sqrt(r * r + d * d) - index * w / sqrt(w * w + depth * depth);
  return r - f / slope;
}

template <class T>
struct PlateModel {
  T thickness_mm{0};
  double index = 1.5;
  Vec3<T> normal;  // unit
};

// t (d'/(d'.m) - d/(d.m)) with d' the direction in the plate, as PlateShift of panel_rays.h.
template <class T>
Vec3<T> PlateShift(const PlateModel<T>& plate, const Vec3<T>& direction) {
  using std::sqrt;
  const T along = direction.dot(plate.normal);
  const Vec3<T> sideways = direction - along * plate.normal;  // per |direction|
  const T length2 = direction.dot(direction), side2 = sideways.dot(sideways);
  const double n = plate.index;
  // Of d' the part along the normal is sqrt(n^2 |d|^2 - side^2)/n, sideways it is side/n.
  const T inside = sqrt(n * n * length2 - side2);
  const T factor =
      plate.thickness_mm * (1.0 / inside - (along < 0.0 ? T(-1.0 / along) : T(1.0 / along)));
  return factor * sideways;
}

// What the directions to all points of one panel in one photograph share.
template <class T>
struct PhotoModel {
  const PanelCalibration* panel = nullptr;
  Vec3<T> eye;  // the camera's centre in the stack's frame
  Eigen::Matrix<T, 4, 1> shape;
  bool emitter = false;
  Mat3<T> stack_from_emitter;  // emitters: rotation, translation, index
  Vec3<T> emitter_origin;
  T index{1};
  bool has_plate = false;
  PlateModel<T> plate;  // normal in the stack's frame
};

// The direction in which an eye sees a point of matter behind the plane z = 0 (stack's frame).
template <class T>
Vec3<T> Towards(const Vec3<T>& eye, const Vec3<T>& point, const T& index) {
  using std::sqrt;
  Vec3<T> straight = point - eye;
  if (!(ValueOf(point.z()) < 0)) return straight;
  // Away from L = 0, where the root has no derivative.
  const T L = sqrt(straight.x() * straight.x() + straight.y() * straight.y() + 1e-18);
  const T part = RefractionCrossing<T>(eye.z(), -point.z(), L, index) / L;
  return {straight.x() * part, straight.y() * part, -eye.z()};
}

// The direction in which the camera's centre sees a panel's pixel, in the stack's frame; of any
// length.
template <class T>
Vec3<T> DirectionTo(const PhotoModel<T>& m, const Eigen::Vector2d& pixel) {
  Vec3<T> point = PanelPoint<T>(*m.panel, m.shape, m.panel->pincushion, pixel);
  if (m.emitter) point = m.stack_from_emitter * point + m.emitter_origin;
  const auto towards = [&](const Vec3<T>& eye) -> Vec3<T> {
    return m.emitter ? Towards<T>(eye, point, m.index) : Vec3<T>(point - eye);
  };
  Vec3<T> direction = towards(m.eye);
  if (m.has_plate) {  // shifts the eye; each round leaves about a thousandth of the error
    for (int i = 0; i < 4; ++i) direction = towards(m.eye + PlateShift<T>(m.plate, direction));
  }
  return direction;
}

}  // namespace lamella::model
