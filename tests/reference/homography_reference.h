// A second renderer of one emissive panel seen by a pinhole camera: the plane is mapped by a
// homography, every panel pixel becomes a quadrilateral and is clipped against every camera pixel
// (Sutherland and Hodgman 1974), so that coverage is exact. Matrices are plain arrays and poses
// rotations about axes, on purpose: nothing here comes from the code under test.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "lightfield/image.h"

namespace lamella::reference {

using Matrix3 = std::array<std::array<double, 3>, 3>;
using Point2 = std::array<double, 2>;
using Point3 = std::array<double, 3>;

inline Matrix3 Times(const Matrix3& a, const Matrix3& b) {
  Matrix3 c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

inline Point3 Times(const Matrix3& a, const Point3& p) {
  Point3 q{};
  for (std::size_t i = 0; i < 3; ++i) q[i] = a[i][0] * p[0] + a[i][1] * p[1] + a[i][2] * p[2];
  return q;
}

inline Matrix3 AboutX(double t) {
  return {{{1, 0, 0}, {0, std::cos(t), -std::sin(t)}, {0, std::sin(t), std::cos(t)}}};
}
inline Matrix3 AboutY(double t) {
  return {{{std::cos(t), 0, std::sin(t)}, {0, 1, 0}, {-std::sin(t), 0, std::cos(t)}}};
}
inline Matrix3 AboutZ(double t) {
  return {{{std::cos(t), -std::sin(t), 0}, {std::sin(t), std::cos(t), 0}, {0, 0, 1}}};
}

struct PlanarPanel {
  int width = 0, height = 0;
  double pitch = 0;
  bool mirrored = false;
  Matrix3 rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // to the display's axes
  Point3 centre{};                                      // in the display
};

struct PlanarCamera {
  int width = 0, height = 0;
  double focal = 0, cx = 0, cy = 0;
  Matrix3 rotation{};  // from the display's axes to the camera's
  Point3 position{};   // in the display
};

// Camera pixel ~ H (u, v, 1).
inline Matrix3 PixelHomography(const PlanarPanel& panel, const PlanarCamera& camera) {
  const Matrix3 turn = Times(camera.rotation, panel.rotation);
  const Point3 between = Times(camera.rotation, Point3{panel.centre[0] - camera.position[0],
                                                       panel.centre[1] - camera.position[1],
                                                       panel.centre[2] - camera.position[2]});
  const double along_u = panel.mirrored ? -panel.pitch : panel.pitch;
  // Panel px (u, v) is the point (along_u (u - W/2), pitch (H/2 - v), 0).
  Matrix3 plane{};
  for (std::size_t i = 0; i < 3; ++i) {
    plane[i][0] = turn[i][0] * along_u;
    plane[i][1] = -turn[i][1] * panel.pitch;
    plane[i][2] = between[i] - turn[i][0] * along_u * panel.width / 2.0 +
                  turn[i][1] * panel.pitch * panel.height / 2.0;
  }
  return Times({{{camera.focal, 0, camera.cx}, {0, camera.focal, camera.cy}, {0, 0, 1}}}, plane);
}

inline Point2 Mapped(const Matrix3& h, double u, double v) {
  const Point3 p = Times(h, Point3{u, v, 1});
  return {p[0] / p[2], p[1] / p[2]};
}

// Keeps the side where sign * (coordinate - limit) >= 0.
inline std::vector<Point2> Clip(const std::vector<Point2>& polygon, std::size_t axis, double limit,
                                double sign) {
  std::vector<Point2> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
    if (da >= 0) kept.push_back(a);
    if ((da >= 0) != (db >= 0)) {
      const double t = da / (da - db);
      kept.push_back({a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])});
    }
  }
  return kept;
}

inline double Area(const std::vector<Point2>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return std::abs(twice) / 2;
}

// The mean light on every camera pixel. The panel lies in front of the camera whole.
inline std::vector<double> RenderPlane(const PlanarPanel& panel, const Image<float>& light,
                                       const PlanarCamera& camera) {
  const Matrix3 h = PixelHomography(panel, camera);
  std::vector<double> picture(static_cast<std::size_t>(camera.width * camera.height), 0.0);
  for (int v = 0; v < panel.height; ++v) {
    for (int u = 0; u < panel.width; ++u) {
      const std::vector<Point2> quad = {Mapped(h, u, v), Mapped(h, u + 1, v),
                                        Mapped(h, u + 1, v + 1), Mapped(h, u, v + 1)};
      Point2 low = quad[0], high = quad[0];
      for (const Point2& p : quad) {
        for (std::size_t k = 0; k < 2; ++k) {
          low[k] = std::min(low[k], p[k]);
          high[k] = std::max(high[k], p[k]);
        }
      }
      const int x1 = std::min(camera.width - 1, static_cast<int>(std::floor(high[0])));
      const int y1 = std::min(camera.height - 1, static_cast<int>(std::floor(high[1])));
      for (int y = std::max(0, static_cast<int>(std::floor(low[1]))); y <= y1; ++y) {
        const auto strip = Clip(Clip(quad, 1, y, 1), 1, y + 1, -1);
        for (int x = std::max(0, static_cast<int>(std::floor(low[0]))); x <= x1; ++x) {
          picture[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                  static_cast<std::size_t>(x)] +=
              Area(Clip(Clip(strip, 0, x, 1), 0, x + 1, -1)) * static_cast<double>(light(u, v));
        }
      }
    }
  }
  return picture;
}

}  // namespace lamella::reference
