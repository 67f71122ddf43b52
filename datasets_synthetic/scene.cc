#include "datasets_synthetic/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "datasets_synthetic/ray_packet.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
// Packets are squares of neighbours, whose rays stay together longest.
constexpr int kTile = 4;
static_assert(kTile * kTile == kPacketRays);

// Rays to the lamp start that far off their surface, in sizes of it: beyond double precision's
// doubt even where coordinates are 1e7 sizes.
constexpr double kLeave = 1e-6;

std::vector<const Shape*> ShapesOf(const Scene& scene) {
  std::vector<const Shape*> shapes;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const Shape& shape = scene.surfaces[i].shape;
    if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&shape)) {
      CheckMesh(**mesh, "the mesh of surface " + std::to_string(i));
    }
    shapes.push_back(&shape);
  }
  return shapes;
}

// Calls body(packet, x, y) for tiles of the rectangle; lane i stands for pixel (x + i % kTile, y +
// i / kTile) of it, where it is active.
template <class Body>
void ForTiles(const RayBundle& bundle, const Rect& rectangle, const Body& body) {
  const bool from_point = bundle.centre.w() != 0;
  RayPacket packet;
  for (int i = 0; i < kPacketRays; ++i) {
    packet.t_min[i] = from_point ? 0 : -kUnbounded;
    packet.t_max[i] = kUnbounded;
    for (int axis = 0; axis < 3; ++axis) {
      packet.origin[axis][i] = bundle.centre(axis);
      packet.direction[axis][i] = -bundle.centre(axis);
    }
  }
  auto& moving = from_point ? packet.direction : packet.origin;  // what RayAt changes
  for (int y = 0; y < rectangle.height; y += kTile) {
    for (int x = 0; x < rectangle.width; x += kTile) {
      const double i0 = rectangle.x + x + 0.5, j0 = rectangle.y + y + 0.5;
      for (int axis = 0; axis < 3; ++axis) {
        const double back = from_point ? bundle.centre(axis) : 0;
        double along_x[kTile], along_y[kTile];
        for (int k = 0; k < kTile; ++k) {
          along_x[k] = bundle.origin(axis) + (i0 + k) * bundle.dx(axis);
          along_y[k] = (j0 + k) * bundle.dy(axis);
        }
        for (int i = 0; i < kPacketRays; ++i) {
          moving[axis][i] = along_x[i % kTile] + along_y[i / kTile] - back;
        }
      }
      for (int i = 0; i < kPacketRays; ++i) {
        const bool inside = x + i % kTile < rectangle.width && y + i / kTile < rectangle.height;
        packet.active[i] = inside ? -1 : 0;
      }
      body(packet, x, y);
    }
  }
}

// A point that is seen, before it is known whether the lamp reaches it.
struct Seen {
  Vector3d point, normal, to_lamp;
  double facing = 0;  // cosine at the lamp's side; <= 0: not lit
  Rgb reflectance;
  double highlight = 0;  // of the lamp's strength
};

double HighlightOf(const Gloss& gloss, const Vector3d& normal, const Vector3d& to_lamp,
                   const Vector3d& direction) {
  if (!(gloss.strength > 0)) return 0;
  const Vector3d lamp = to_lamp.normalized();
  const Vector3d mirrored = 2 * normal.dot(lamp) * normal - lamp;
  const double cosine = -mirrored.dot(direction) / direction.norm();
  return cosine > 0 ? gloss.strength * std::pow(cosine, gloss.exponent) : 0;
}

Rgb ReflectanceOf(const Surface& surface, const ShapePoint& at, const Vector3d& point,
                  double footprint) {
  if (const auto* image = std::get_if<ImageTexture>(&surface.texture)) {
    return ColorAt(*image, at.uv, footprint * at.uv_per_length);
  }
  const Texture& texture = std::get<Texture>(surface.texture);
  const auto* p = std::get_if<Parallelogram>(&surface.shape);
  if (p != nullptr && texture.pattern == Texture::Pattern::kChecker) {
    // Squares in the plane, from the corner on.
    const Vector3d u = p->u.normalized(), within = point - p->corner;
    const double half = 0.5 * texture.scale;
    return ColorAt(texture, {within.dot(u) + half, within.dot(at.face_normal.cross(u)) + half, 0},
                   footprint, Vector3d::UnitZ());
  }
  return ColorAt(texture, point - AnchorOf(surface.shape), footprint, at.face_normal);
}

// `cell`: side of the patch across the ray that it stands for, world units.
Seen See(const Scene& scene, const Ray& ray, const SurfaceHit& hit, double cell) {
  const Surface& surface = scene.surfaces[static_cast<std::size_t>(hit.surface)];
  Seen seen;
  seen.point = ray.origin + hit.t * ray.direction;
  ShapePoint at = PointOf(surface.shape, hit.triangle, seen.point);
  if (at.face_normal.dot(ray.direction) > 0) {  // the side that is seen
    at.face_normal = -at.face_normal;
    at.normal = -at.normal;
  }
  // Seen at an angle the patch grows by 1/cos; the limit keeps a grazing surface from going grey.
  const double cosine = -at.face_normal.dot(ray.direction) / ray.direction.norm();
  seen.reflectance = ReflectanceOf(surface, at, seen.point, cell / std::max(cosine, 0.15));

  seen.to_lamp = scene.lighting.lamp - seen.point;
  const bool before = at.face_normal.dot(seen.to_lamp) > 0;
  seen.facing = before ? at.normal.dot(seen.to_lamp) / seen.to_lamp.norm() : 0;
  if (seen.facing > 0) {
    seen.highlight = HighlightOf(surface.gloss, at.normal, seen.to_lamp, ray.direction);
  }
  return seen;
}

// Which of the points that were hit does the lamp reach?
void FollowToLamp(const EmbreeScene& embree, const PacketHits& hits, const Seen* seen,
                  bool* reached) {
  RayPacket packet{};
  packet.any_hit = true;
  for (int i = 0; i < kPacketRays; ++i) {
    reached[i] = hits.surface[i] >= 0 && seen[i].facing > 0;
    if (!reached[i]) continue;
    for (int axis = 0; axis < 3; ++axis) {
      packet.origin[axis][i] = seen[i].point(axis);
      packet.direction[axis][i] = seen[i].to_lamp(axis);
    }
    // From a little off the surface, so that it does not shade itself; up to the lamp at t = 1.
    packet.t_min[i] = kLeave * embree.SizeOf(hits.surface[i]) / seen[i].to_lamp.norm();
    packet.t_max[i] = 1;
    packet.active[i] = -1;
  }
  PacketHits blockers;
  embree.FirstHits(packet, &blockers);
  for (int i = 0; i < kPacketRays; ++i) reached[i] = reached[i] && blockers.surface[i] < 0;
}

Rgb Lit(const Seen& seen, const Lighting& lighting, bool reached) {
  float light = lighting.ambient;
  if (reached) light += lighting.lamp_strength * static_cast<float>(seen.facing);
  Rgb color = light * seen.reflectance;
  if (reached && seen.highlight > 0) {
    const float white = lighting.lamp_strength * static_cast<float>(seen.highlight);
    color += Rgb{white, white, white};
  }
  return color;
}

}  // namespace

SceneSource::SceneSource(Scene scene) : scene_(std::move(scene)), embree_(ShapesOf(scene_)) {}

std::optional<SurfaceHit> SceneSource::FirstHit(const Ray& ray, double t_min) const {
  return embree_.FirstHit(ray, t_min);
}

void SceneSource::QueryDepth(const RayBundle& bundle, const Rect& rectangle,
                             ImageSpan<float> t) const {
  PacketHits hits;
  ForTiles(bundle, rectangle, [&](const RayPacket& packet, int x, int y) {
    embree_.FirstHits(packet, &hits);
    for (int i = 0; i < kPacketRays; ++i) {
      if (packet.active[i] == 0) continue;
      const double found = hits.surface[i] < 0 ? kUnbounded : hits.t[i];
      t(x + i % kTile, y + i / kTile) = static_cast<float>(found);
    }
  });
}

void SceneSource::Query(const RayBundle& bundle, const Rect& rectangle,
                        ImageSpan<RaySample> samples) const {
  constexpr int kBandRows = 16;  // whole packets
  const int bands = (rectangle.height + kBandRows - 1) / kBandRows;
  if (bands <= 1) return QueryBand(bundle, rectangle, samples);
  ParallelForEach(0, bands, [&](std::int64_t band) {
    const int first = static_cast<int>(band) * kBandRows;
    const int rows = std::min(kBandRows, rectangle.height - first);
    QueryBand(bundle, {rectangle.x, rectangle.y + first, rectangle.width, rows},
              samples.Sub({0, first, rectangle.width, rows}));
  });
}

void SceneSource::QueryBand(const RayBundle& bundle, const Rect& rectangle,
                            ImageSpan<RaySample> samples) const {
  const bool from_point = bundle.centre.w() != 0;
  const Vector3d normal = bundle.Normal();
  const double cell_on_plane = bundle.footprint * std::max(bundle.dx.norm(), bundle.dy.norm());
  PacketHits hits;
  ForTiles(bundle, rectangle, [&](const RayPacket& packet, int x, int y) {
    embree_.FirstHits(packet, &hits);
    Seen seen[kPacketRays];
    for (int i = 0; i < kPacketRays; ++i) {
      if (packet.active[i] == 0 || hits.surface[i] < 0) continue;
      const SurfaceHit hit{hits.surface[i], hits.t[i], hits.triangle[i]};
      // Rays of a point spread: at t = 1 they are on the plane.
      seen[i] = See(scene_, packet.At(i), hit, from_point ? hit.t * cell_on_plane : cell_on_plane);
    }
    bool reached[kPacketRays];
    FollowToLamp(embree_, hits, seen, reached);
    for (int i = 0; i < kPacketRays; ++i) {
      if (packet.active[i] == 0) continue;
      RaySample& sample = samples(x + i % kTile, y + i / kTile);
      sample = RaySample{.color = scene_.background, .confidence = 1, .coverage = 1};
      if (hits.surface[i] < 0) continue;
      sample.color = Lit(seen[i], scene_.lighting, reached[i]);
      sample.z = static_cast<float>((seen[i].point - bundle.origin).dot(normal));
    }
  });
}

}  // namespace lamella
