#include "tests/depth/synthetic.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Geometry>

namespace lamella::synthetic {
namespace {

using Eigen::Vector3d;

double Hash(int x, int y, int seed) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
           static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
           static_cast<std::uint32_t>(seed) * 0xC2B2AE3DU;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  h *= 0x297A2D39U;
  h ^= h >> 15;
  return static_cast<double>(h) / 4294967295.0;
}

// Values of [0, 1] at whole numbers, smoothly between them.
double Noise(double x, double y, int seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double u = ease(x - fx), v = ease(y - fy);
  const double top = (1 - u) * Hash(ix, iy, seed) + u * Hash(ix + 1, iy, seed);
  const double bottom = (1 - u) * Hash(ix, iy + 1, seed) + u * Hash(ix + 1, iy + 1, seed);
  return (1 - v) * top + v * bottom;
}

Vector3d Texture(const Panel& panel, double a, double b) {
  if (!panel.textured) return Vector3d::Constant(128);
  Vector3d color;
  for (int c = 0; c < 3; ++c) {
    double value = 0;
    for (int octave = 0; octave < 3; ++octave) {
      const double scale = 1 / (panel.detail * std::pow(2.5, octave));
      value += Noise(a * scale, b * scale, panel.seed * 31 + c * 7 + octave) / 3;
    }
    color[c] = 255 * std::clamp(0.5 + 1.8 * (value - 0.5), 0.0, 1.0);
  }
  return color;
}

struct Hit {
  double depth = 0;
  Vector3d color = Vector3d::Zero();
};

Hit Trace(const std::vector<Panel>& panels, const Vector3d& centre, const Vector3d& ray) {
  Hit nearest;
  double best = std::numeric_limits<double>::infinity();
  for (const Panel& panel : panels) {
    const Vector3d normal = panel.u.cross(panel.v);
    const double along = normal.dot(ray);
    if (std::abs(along) < 1e-12) continue;
    const double t = normal.dot(panel.origin - centre) / along;  // ray has depth 1
    if (!(t > 0) || t >= best) continue;
    const Vector3d point = centre + t * ray - panel.origin;
    const double a = point.dot(panel.u), b = point.dot(panel.v);
    if (std::abs(a) > panel.half_u || std::abs(b) > panel.half_v) continue;
    best = t;
    nearest = {t, Texture(panel, a, b)};
  }
  return nearest;
}

}  // namespace

Picture Render(const std::vector<Panel>& panels, const Camera& camera,
               const Rigid& camera_from_world) {
  const Rigid world_from_camera = Inverse(camera_from_world);
  const auto ray = [&](double x, double y) -> Vector3d {
    return world_from_camera.rotation *
           Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
  };
  constexpr int kSide = 4;
  Picture picture{Image<Rgb8>(camera.width, camera.height),
                  Image<float>(camera.width, camera.height)};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Vector3d sum = Vector3d::Zero();
      for (int i = 0; i < kSide * kSide; ++i) {
        const int column = i % kSide, row = i / kSide;
        sum += Trace(panels, world_from_camera.translation,
                     ray(x + (column + 0.5) / kSide, y + (row + 0.5) / kSide))
                   .color;
      }
      const auto code = [&](int c) {
        return static_cast<std::uint8_t>(std::lround(sum[c] / (kSide * kSide)));
      };
      picture.image(x, y) = {code(0), code(1), code(2)};
      picture.depth(x, y) = static_cast<float>(
          Trace(panels, world_from_camera.translation, ray(x + 0.5, y + 0.5)).depth);
    }
  }
  return picture;
}

Rigid LookAt(const Vector3d& centre, const Vector3d& target) {
  const Vector3d z = (target - centre).normalized();
  const Vector3d x = Vector3d(0, 1, 0).cross(z).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << x, z.cross(x), z;
  const Eigen::Quaterniond rotation(Eigen::Matrix3d(world_from_camera.transpose()));
  return {rotation, -(rotation * centre)};
}

Camera Pinhole(int width, int height, double focal_px) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_px;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

std::vector<View> MakeGrid(int rows, int columns, int size, double focal_px, double baseline,
                           double zero_depth, int every) {
  std::vector<View> views;
  for (int r = 0; r < rows; r += every) {
    for (int c = 0; c < columns; c += every) {
      const double x = c - (columns - 1) / 2.0, y = r - (rows - 1) / 2.0;
      View view;
      view.name = "view" + std::to_string(100 + r * columns + c);
      view.camera = Pinhole(size, size, focal_px);
      view.camera.cx += x * focal_px * baseline / zero_depth;
      view.camera.cy += y * focal_px * baseline / zero_depth;
      view.camera_from_world.translation = Vector3d(-x * baseline, -y * baseline, 0);
      view.grid = GridPosition{r, c};
      views.push_back(view);
    }
  }
  return views;
}

}  // namespace lamella::synthetic
