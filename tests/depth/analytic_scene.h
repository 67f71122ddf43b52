// Scenes of textured rectangles with colour and depth in closed form: truth for rendering.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "depth/render.h"
#include "lightfield/camera.h"
#include "lightfield/ray_source.h"
#include "lightfield/rigid.h"

namespace lamella::testing_scene {

// A rectangle centre +- half_u u +- half_v v (u, v unit and orthogonal) with a smooth texture of
// wavelengths from `wavelength` on; infinite halves make it a whole plane.
struct TexturedRectangle {
  Eigen::Vector3d centre{0, 0, 8}, u{1, 0, 0}, v{0, 1, 0};
  double half_u = std::numeric_limits<double>::infinity();
  double half_v = std::numeric_limits<double>::infinity();
  double wavelength = 0.4, phase = 0, brightness = 0.4;

  Rgb Color(double s, double t) const {
    const double k = 2 * 3.14159265358979 / wavelength;
    const auto wave = [&](double a, double b, double c) {
      return std::sin(k * (a * s + b * t) + c + phase);
    };
    const auto channel = [&](double c) {
      return static_cast<float>(brightness *
                                (1 + 0.35 * wave(0.9, 0.3, c) + 0.35 * wave(-0.2, 0.8, 2 * c) +
                                 0.25 * wave(0.31, -0.27, 3 * c)));
    };
    return {channel(0), channel(1), channel(2.5)};
  }
};

struct Hit {
  Rgb color;
  double t = std::numeric_limits<double>::infinity();  // along the ray's direction
};

class PlaneScene : public RaySource {
 public:
  explicit PlaneScene(std::vector<TexturedRectangle> rectangles)
      : rectangles_(std::move(rectangles)) {}

  // `from`: smallest t that counts; rays of a direction come from behind the viewer's plane.
  Hit Trace(const Ray& ray, double from = 0) const {
    Hit hit;
    for (const TexturedRectangle& r : rectangles_) {
      const Eigen::Vector3d normal = r.u.cross(r.v);
      const double t = (r.centre - ray.origin).dot(normal) / ray.direction.dot(normal);
      if (!(t > from) || !(t < hit.t)) continue;
      const Eigen::Vector3d on = ray.origin + t * ray.direction - r.centre;
      if (std::abs(on.dot(r.u)) > r.half_u || std::abs(on.dot(r.v)) > r.half_v) continue;
      hit = {r.Color(on.dot(r.u), on.dot(r.v)), t};
    }
    return hit;
  }

  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    const bool point = bundle.centre.w() != 0;
    for (int y = 0; y < rectangle.height; ++y) {
      for (int x = 0; x < rectangle.width; ++x) {
        const double i = rectangle.x + x + 0.5, j = rectangle.y + y + 0.5;
        const Ray ray = bundle.RayAt(i, j);
        const Hit hit = Trace(ray, point ? 0 : -1e9);
        RaySample& sample = samples(x, y);
        sample = {hit.color, -std::numeric_limits<float>::infinity(), 1, 1};
        if (!std::isfinite(hit.t)) continue;
        const Eigen::Vector3d at = ray.origin + hit.t * ray.direction;
        sample.z = static_cast<float>((at - bundle.origin).dot(bundle.Normal()));
      }
    }
  }

  // A view with exact colours and depths at the pixel centres.
  DepthView Capture(const Camera& camera, const Rigid& camera_from_world) const {
    const RayBundle bundle = BundleOfCamera(camera, camera_from_world);
    Image<RaySample> samples(camera.width, camera.height);
    Query(bundle, {0, 0, camera.width, camera.height}, samples.span());
    DepthView view;
    view.view.camera = camera;
    view.view.camera_from_world = camera_from_world;
    view.color = Image<Rgb>(camera.width, camera.height);
    view.depth = {Image<float>(camera.width, camera.height),
                  Image<float>(camera.width, camera.height, 1.0F)};
    for (std::size_t i = 0; i < samples.size(); ++i) {
      view.color.data()[i] = samples.data()[i].color;
      view.depth.depth.data()[i] = 1.0F - samples.data()[i].z;
    }
    return view;
  }

 private:
  std::vector<TexturedRectangle> rectangles_;
};

inline Camera PinholeOf(int width, int height, double focal) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal;
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  return camera;
}

// A camera at `centre` that looks along z, turned by `angle` about y.
inline Rigid PoseAt(const Eigen::Vector3d& centre, double angle = 0) {
  Rigid world_from_camera;
  world_from_camera.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY());
  world_from_camera.translation = centre;
  return Inverse(world_from_camera);
}

// A slanted back wall and a rectangle in front of it.
inline PlaneScene TwoPlanes() {
  TexturedRectangle wall;
  wall.centre = {0, 0, 9};
  wall.u = Eigen::Vector3d(1, 0, 0.2).normalized();
  TexturedRectangle front;
  front.centre = {0.2, -0.1, 5};
  front.half_u = 0.9;
  front.half_v = 0.7;
  front.wavelength = 0.3;
  front.phase = 1;
  front.brightness = 0.25;
  return PlaneScene({wall, front});
}

}  // namespace lamella::testing_scene
