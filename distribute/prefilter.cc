#include "distribute/prefilter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

struct Point {
  double position = 0, aim = 0;
};

// A convex polygon. Clipping a parallelogram by three half-planes leaves at most seven corners.
struct Polygon {
  std::array<Point, 8> corners;
  int size = 0;
  void Add(const Point& point) { corners[static_cast<std::size_t>(size++)] = point; }
  const Point& operator[](int i) const { return corners[static_cast<std::size_t>(i % size)]; }
};

double Area(const Polygon& polygon) {
  double twice = 0;
  for (int i = 0; i < polygon.size; ++i) {
    const Point &p = polygon[i], &q = polygon[i + 1];
    // From a corner, so that far-off polygons lose no digits.
    const Point& o = polygon[0];
    twice +=
        (p.position - o.position) * (q.aim - o.aim) - (q.position - o.position) * (p.aim - o.aim);
  }
  return std::abs(twice) / 2;
}

// The part where depth(point) <= 0; depth is affine (Sutherland and Hodgman).
template <class Depth>
Polygon Clip(const Polygon& polygon, Depth depth) {
  Polygon inside;
  for (int i = 0; i < polygon.size; ++i) {
    const Point &p = polygon[i], &q = polygon[i + 1];
    const double dp = depth(p), dq = depth(q);
    if (dp <= 0) inside.Add(p);
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      const double t = dp / (dp - dq);
      inside.Add({p.position + t * (q.position - p.position), p.aim + t * (q.aim - p.aim)});
    }
  }
  return inside;
}

Polygon ClipToStrip(const Polygon& polygon, double low, double high) {
  return Clip(Clip(polygon, [low](const Point& p) { return low - p.aim; }),
              [high](const Point& p) { return p.aim - high; });
}

double AreaBefore(const Polygon& polygon, double position) {
  return Area(Clip(polygon, [position](const Point& p) { return p.position - position; }));
}

struct Interval {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
};

template <class Value>
Interval IntervalOf(const Polygon& polygon, Value value) {
  Interval interval;
  for (int i = 0; i < polygon.size; ++i) {
    interval.min = std::min(interval.min, value(polygon[i]));
    interval.max = std::max(interval.max, value(polygon[i]));
  }
  return interval;
}

// What remains of a beam's widths where its central line alone is meant, and of an emitter that has
// no width of its own: an area to divide by.
constexpr double kRayWidth = 1e-6;

// All lines of the beam: position on the plane z = content_mm, aim.
Polygon PolygonOf(const AxisBeam& beam, double layer_mm, double content_mm, const AimPlane& aim,
                  Kernel kernel) {
  Polygon polygon;
  const double width = kernel == Kernel::kRay ? kRayWidth : 1;
  // Of the place in the element, the share by which the slope goes with it: kappa d0, 1 of a hole.
  const double spread = kernel == Kernel::kBeam ? beam.kappa_per_mm() * beam.d0_mm : 0;
  const double emitter_width = std::max(beam.emitter_width_mm, kRayWidth * beam.aperture_mm);
  constexpr std::array<std::array<double, 2>, 4> kCorners = {
      {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
  for (const auto& [a, b] : kCorners) {
    const double offset = width * a * beam.aperture_mm;
    const double element = beam.element_mm + offset;
    const double slope = beam.slope() + (spread * offset - width * b * emitter_width) / beam.d0_mm;
    polygon.Add({element + slope * (content_mm - layer_mm),
                 aim.points ? element + slope * (aim.distance_mm - layer_mm) : slope});
  }
  return polygon;
}

// Moves positions from the content plane to z = 0 along the node's rays.
void MoveToReference(Polygon& polygon, const AimPlane& aim, double content_mm, double node) {
  for (int i = 0; i < polygon.size; ++i) {
    double& position = polygon.corners[static_cast<std::size_t>(i)].position;
    position = aim.points
                   ? node + (position - node) * aim.distance_mm / (aim.distance_mm - content_mm)
                   : position - node * content_mm;
  }
}

// Appends the overlap of a beam's part with the samples; nothing where it has no area.
void AddOverlap(const Polygon& part, double beam_area, const SampleAxis& samples,
                const EmitterBeam& beam, AxisOverlaps& overlaps, std::vector<Overlap>& node) {
  const Interval span = IntervalOf(part, [](const Point& p) { return p.position; });
  const auto sample_of = [&](double position) {
    return static_cast<int>(std::floor((position - samples.origin_mm) / samples.size_mm));
  };
  Overlap overlap{beam.slot,   beam.emitter,
                  beam.family, sample_of(span.min),
                  0,           static_cast<std::uint32_t>(overlaps.weights.size())};
  const int last = sample_of(span.max);
  // Corners that left their strip by rounding must not make a sample of no weight.
  constexpr double kNegligible = 1e-9;
  double before = 0;
  for (int j = overlap.first_sample; j <= last; ++j) {
    const double until = AreaBefore(part, samples.origin_mm + (j + 1) * samples.size_mm);
    const double weight = (until - before) / beam_area;
    before = until;
    if (weight < kNegligible && overlap.num_samples == 0) {
      ++overlap.first_sample;
    } else if (weight < kNegligible && j == last) {
      break;
    } else {
      overlaps.weights.push_back(static_cast<float>(std::max(weight, 0.0)));
      ++overlap.num_samples;
    }
  }
  if (overlap.num_samples > 0) node.push_back(overlap);
}

}  // namespace

AimRange AimsOf(std::span<const EmitterBeam> beams, double layer_mm, const AimPlane& aim,
                Kernel kernel) {
  Interval all;
  for (const EmitterBeam& emitter : beams) {
    const Polygon polygon = PolygonOf(emitter.beam, layer_mm + emitter.offset_mm,
                                      layer_mm + emitter.offset_mm, aim, kernel);
    const Interval aims = IntervalOf(polygon, [](const Point& p) { return p.aim; });
    all.min = std::min(all.min, aims.min);
    all.max = std::max(all.max, aims.max);
  }
  return {all.min, all.max};
}

AxisOverlaps OverlapsOf(std::span<const EmitterBeam> beams, double layer_mm, const AimPlane& aim,
                        double content_mm, const NodeAxis& nodes, const SampleAxis& samples,
                        Kernel kernel) {
  AxisOverlaps overlaps;
  overlaps.nodes.resize(static_cast<std::size_t>(nodes.count));
  if (nodes.count == 0) return overlaps;
  const auto node_of = [&](double a) {
    return std::clamp(static_cast<int>(std::floor((a - nodes.first) / nodes.step + 0.5)), 0,
                      nodes.count - 1);
  };
  for (const EmitterBeam& emitter : beams) {
    const double content = content_mm + emitter.offset_mm;
    // Of areas by the move to z = 0.
    const double stretch = aim.points ? aim.distance_mm / (aim.distance_mm - content) : 1.0;
    const Polygon polygon =
        PolygonOf(emitter.beam, layer_mm + emitter.offset_mm, content, aim, kernel);
    const double area = Area(polygon) * stretch;
    const Interval aims = IntervalOf(polygon, [](const Point& p) { return p.aim; });
    for (int k = node_of(aims.min); k <= node_of(aims.max); ++k) {
      const double centre = nodes.Centre(k);
      Polygon part = ClipToStrip(polygon, centre - nodes.step / 2, centre + nodes.step / 2);
      if (part.size < 3) continue;
      MoveToReference(part, aim, content, centre);
      AddOverlap(part, area, samples, emitter, overlaps,
                 overlaps.nodes[static_cast<std::size_t>(k)]);
    }
  }
  return overlaps;
}

}  // namespace lamella
