// A scene of rectangles parallel to the display, each with a colour given by a function: asked ray
// by ray, so that its answers are exact.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "lightfield/ray_source.h"

namespace lamella {

struct Rectangle {
  double z = 0;
  double left = -1e9, right = 1e9, bottom = -1e9, top = 1e9;
  std::function<Rgb(double x, double y)> color;
};

class AnalyticScene final : public RaySource {
 public:
  std::vector<Rectangle> rectangles;
  bool background_known = true;  // black at infinity; else coverage 0

  // The first rectangle that the line meets, coming from its direction's tail (`direction` points
  // away from the viewer, z < 0).
  RaySample Trace(const Ray& ray) const {
    RaySample sample;
    sample.coverage = background_known ? 1.0F : 0.0F;
    double nearest = -std::numeric_limits<double>::infinity();
    for (const Rectangle& r : rectangles) {
      const double t = (r.z - ray.origin.z()) / ray.direction.z();
      const Eigen::Vector3d p = ray.origin + t * ray.direction;
      if (p.x() < r.left || p.x() > r.right || p.y() < r.bottom || p.y() > r.top) continue;
      if (r.z <= nearest) continue;
      nearest = r.z;
      sample.color = r.color(p.x(), p.y());
      sample.z = static_cast<float>(r.z);
      sample.confidence = sample.coverage = 1;
    }
    return sample;
  }

  // For bundles whose plane is z = const of the display's frame.
  void Query(const RayBundle& bundle, const Rect& rect,
             ImageSpan<RaySample> samples) const override {
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        samples(x, y) = Trace(bundle.RayAt(rect.x + x + 0.5, rect.y + y + 0.5));
        samples(x, y).z -= static_cast<float>(bundle.origin.z());
      }
    }
  }
};

}  // namespace lamella
