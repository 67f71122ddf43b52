#include "datasets_synthetic/embree_mesh.h"

#include <cmath>
#include <limits>
#include <string>

#include "datasets_synthetic/embree_api-inl.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// In radii of the mesh: coordinates of single precision in [-1.5, 1.5], two of which meet in a
// candidate, are off by less.
constexpr double kSlack = 2e-6;
// Nearer than this to the ray's start, two candidates closer together than kSlack might differ by
// more than 1e-5 of their distance: then all that are as near are asked.
constexpr double kNear = 0.05;

bool HasArea(const Vector3d& e1, const Vector3d& e2) {
  return e1.cross(e2).squaredNorm() > 1e-28 * e1.squaredNorm() * e2.squaredNorm();
}

// Where a ray meets a triangle's plane (Moeller and Trumbore 1997): the weights of its corners, all
// times det, and t.
struct PlanePoint {
  double det = 0, a = 0, b = 0, c = 0, t = 0;
  double least() const { return std::min(a, std::min(b, c)); }
};

inline PlanePoint MeetPlane(const Mesh& mesh, unsigned triangle, const Vector3d& origin,
                            const Vector3d& direction) {
  const Vector3i& corners = mesh.triangles[triangle];
  const Vector3d& v0 = mesh.vertices[static_cast<unsigned>(corners.x())];
  const Vector3d e1 = mesh.vertices[static_cast<unsigned>(corners.y())] - v0;
  const Vector3d e2 = mesh.vertices[static_cast<unsigned>(corners.z())] - v0;
  const Vector3d p = direction.cross(e2), s = origin - v0, q = s.cross(e1);
  PlanePoint found;
  const double det = e1.dot(p), sign = det < 0 ? -1 : 1;
  found.det = sign * det;
  found.b = sign * s.dot(p);
  found.c = sign * direction.dot(q);
  found.a = found.det - found.b - found.c;
  found.t = e2.dot(q) / det;
  return found;
}

// A ray that meets the plane outside of the triangle: t of the ray's point next to the triangle's
// point of the nearest weights. Stays by the triangle however the plane is inclined.
double NextTo(const Mesh& mesh, unsigned triangle, const PlanePoint& found, const Ray& ray) {
  const Vector3i& corners = mesh.triangles[triangle];
  const double a = std::max(found.a, 0.0), b = std::max(found.b, 0.0), c = std::max(found.c, 0.0);
  const double sum = a + b + c;
  const Vector3d& v0 = mesh.vertices[static_cast<unsigned>(corners.x())];
  const Vector3d point = v0 + b / sum * (mesh.vertices[static_cast<unsigned>(corners.y())] - v0) +
                         c / sum * (mesh.vertices[static_cast<unsigned>(corners.z())] - v0);
  return (point - ray.origin).dot(ray.direction) / ray.direction.squaredNorm();
}

// The same for all lanes of a packet, each with a triangle of its own.
struct PacketCorners {
  alignas(64) double v0[3][kPacketRays];
  alignas(64) double v1[3][kPacketRays];
  alignas(64) double v2[3][kPacketRays];
};
struct PacketPlanes {
  alignas(64) double det[kPacketRays];
  alignas(64) double least[kPacketRays];
  alignas(64) double t[kPacketRays];
};

LAMELLA_LANES void MeetPlaneLanes(const RayPacket& __restrict rays,
                                  const PacketCorners& __restrict corners,
                                  PacketPlanes* __restrict planes) {
  for (int i = 0; i < kPacketRays; ++i) {
    const double dx = rays.direction[0][i], dy = rays.direction[1][i], dz = rays.direction[2][i];
    const double ax = corners.v1[0][i] - corners.v0[0][i], bx = corners.v2[0][i] - corners.v0[0][i];
    const double ay = corners.v1[1][i] - corners.v0[1][i], by = corners.v2[1][i] - corners.v0[1][i];
    const double az = corners.v1[2][i] - corners.v0[2][i], bz = corners.v2[2][i] - corners.v0[2][i];
    const double sx = rays.origin[0][i] - corners.v0[0][i];
    const double sy = rays.origin[1][i] - corners.v0[1][i];
    const double sz = rays.origin[2][i] - corners.v0[2][i];
    const double px = dy * bz - dz * by, py = dz * bx - dx * bz, pz = dx * by - dy * bx;
    const double qx = sy * az - sz * ay, qy = sz * ax - sx * az, qz = sx * ay - sy * ax;
    const double det = ax * px + ay * py + az * pz, sign = det < 0 ? -1 : 1;
    const double u = sign * (sx * px + sy * py + sz * pz);
    const double v = sign * (dx * qx + dy * qy + dz * qz);
    const double w = sign * det - u - v, u_or_v = u < v ? u : v;
    planes->det[i] = sign * det;
    planes->least[i] = u_or_v < w ? u_or_v : w;
    planes->t[i] = (bx * qx + by * qy + bz * qz) / det;
  }
}

void MeetPlanesAnywhere(const RayPacket& rays, const PacketCorners& corners, PacketPlanes* planes) {
  MeetPlaneLanes(rays, corners, planes);
}
LAMELLA_AVX2 void MeetPlanesAvx2(const RayPacket& rays, const PacketCorners& corners,
                                 PacketPlanes* planes) {
  MeetPlaneLanes(rays, corners, planes);
}

// Lanes that met nothing take the corners of triangle 0. Memory is asked for all lanes' triangles
// before the first one's vertices, for it is slow to answer.
void TakeCorners(const Mesh& mesh, const FramedPacket& framed, PacketCorners* corners) {
  const auto& hit = framed.rayhit.hit;
  int index[kPacketRays][3];
  for (int i = 0; i < kPacketRays; ++i) {
    const bool met = framed.valid[i] != 0 && hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    const int* const t = mesh.triangles[met ? hit.primID[i] : 0].data();
    for (int k = 0; k < 3; ++k) index[i][k] = t[k];
  }
  for (int i = 0; i < kPacketRays; ++i) {
    const double* const v0 = mesh.vertices[static_cast<unsigned>(index[i][0])].data();
    const double* const v1 = mesh.vertices[static_cast<unsigned>(index[i][1])].data();
    const double* const v2 = mesh.vertices[static_cast<unsigned>(index[i][2])].data();
    for (int axis = 0; axis < 3; ++axis) {
      corners->v0[axis][i] = v0[axis];
      corners->v1[axis][i] = v1[axis];
      corners->v2[axis][i] = v2[axis];
    }
  }
}

// What the filter needs besides Embree's own ray. Embree hands the context through.
struct ExactQuery {
  EmbreeContext context;  // first, so that a pointer to it is a pointer to the query
  const Mesh* mesh = nullptr;
  const Ray* ray = nullptr;
  double t_min = 0, t_max = 0;
  FramedRay* framed = nullptr;
  float tfar = 0;
  std::optional<TriangleHit> inside;   // in double precision, too
  std::optional<TriangleHit> next_to;  // in single precision only
};

// Of triangles at one t (an edge), the first in the list.
void Improve(std::optional<TriangleHit>* best, int triangle, double t) {
  if (*best) {
    const double same = 1e-12 * std::abs(t);
    if (t > (*best)->t + same) return;
    if (t >= (*best)->t - same && triangle > (*best)->triangle) return;
  }
  *best = TriangleHit{triangle, t};
}

// Every candidate of single precision comes by here: first those that are no farther than the best
// one so far, and kSlack.
void AskTriangle(const RTCFilterFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  arguments->valid[0] = 0;  // not taken, so that the others are asked, too
  auto& query = *reinterpret_cast<ExactQuery*>(arguments->context);
  const unsigned triangle = RTCHitN_primID(arguments->hit, arguments->N, 0);
  const PlanePoint found =
      MeetPlane(*query.mesh, triangle, query.ray->origin, query.ray->direction);
  if (!(found.det > 0) || !std::isfinite(found.t)) return;
  const bool is_inside = found.least() >= 0;
  const double t = is_inside ? found.t : NextTo(*query.mesh, triangle, found, *query.ray);
  if (!(t > query.t_min && t < query.t_max)) return;
  Improve(is_inside ? &query.inside : &query.next_to, static_cast<int>(triangle), t);
  if (!is_inside) return;
  const double far = (t - query.framed->t_start) * query.framed->per_t + 2 * kSlack;
  query.tfar = std::min(query.tfar, RoundUp(far));
  RTCRayN_tfar(arguments->ray, arguments->N, 0) = query.tfar;
  arguments->valid[0] = -1;  // taken: Embree goes on with this tfar
}

// The only lane that is asked; -1 where there are more, or none.
int OnlyLane(const int* valid) {
  int lane = -1;
  for (int i = 0; i < kPacketRays; ++i) {
    if (valid[i] == 0) continue;
    if (lane >= 0) return -1;
    lane = i;
  }
  return lane;
}

}  // namespace

void ThrowEmbreeError(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  throw MachineError(
      "", "Embree can't build the scene (error " + std::to_string(static_cast<int>(error)) + ")",
      "use a smaller scene or free some memory");
}

struct EmbreeMesh::Impl {
  const Mesh* mesh = nullptr;
  Frame frame;
  ScenePtr scene;
};

EmbreeMesh::EmbreeMesh(RTCDevice device, const Mesh& mesh) : impl_(std::make_unique<Impl>()) {
  impl_->mesh = &mesh;
  const Eigen::AlignedBox3d box = BoundsOf(mesh);
  impl_->frame.centre = 0.5 * box.min() + 0.5 * box.max();
  impl_->frame.radius =
      std::max(0.5 * (box.max() - box.min()).norm(), std::numeric_limits<double>::min());

  const FlushDenormals flush;
  impl_->scene.reset(rtcNewScene(device));
  rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST | kFilterPerQuery);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    ThrowEmbreeError(device);
    throw MachineError("", "Embree can't hold a mesh of this size", "free some memory");
  }
  for (const Vector3d& vertex : mesh.vertices) {
    for (int i = 0; i < 3; ++i) {
      *vertices++ = static_cast<float>((vertex(i) - impl_->frame.centre(i)) / impl_->frame.radius);
    }
  }
  for (const Vector3i& t : mesh.triangles) {
    const auto corner = [&](int i) { return mesh.vertices[static_cast<std::size_t>(t(i))]; };
    // A point has no area in single precision either.
    const bool seen = HasArea(corner(1) - corner(0), corner(2) - corner(0));
    for (int i = 0; i < 3; ++i) *indices++ = static_cast<unsigned>(seen ? t(i) : t(0));
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene.get());
  ThrowEmbreeError(device);
}

EmbreeMesh::~EmbreeMesh() = default;
EmbreeMesh::EmbreeMesh(EmbreeMesh&&) noexcept = default;
EmbreeMesh& EmbreeMesh::operator=(EmbreeMesh&&) noexcept = default;

RTCScene EmbreeMesh::scene() const { return impl_->scene.get(); }
Vector3d EmbreeMesh::centre() const { return impl_->frame.centre; }
double EmbreeMesh::radius() const { return impl_->frame.radius; }

std::optional<TriangleHit> EmbreeMesh::FirstHit(const Ray& ray, double t_min, double t_max) const {
  FramedRay framed;
  if (!ToFrame(ray, t_min, t_max, kSlack, impl_->frame, &framed)) return std::nullopt;
  ExactQuery query;
  query.mesh = impl_->mesh;
  query.ray = &ray;
  query.t_min = t_min;
  query.t_max = t_max;
  query.framed = &framed;
  query.tfar = framed.rayhit.ray.tfar;
  const FlushDenormals flush;
  Intersect1(impl_->scene.get(), &query.context, &AskTriangle, &framed.rayhit);
  // A triangle that only single precision meets counts where no triangle beside it is met in
  // double precision: at a rim.
  if (!query.inside) return query.next_to;
  if (query.next_to && query.next_to->t < query.inside->t - 4 * kSlack / framed.per_t) {
    return query.next_to;
  }
  return query.inside;
}

void EmbreeMesh::FirstHits(const RayPacket& rays, const int* valid, const double* t_max,
                           int surface, PacketHits* hits) const {
  const auto take = [&](int i, int triangle, double t) {
    hits->t[i] = t;
    hits->triangle[i] = triangle;
    hits->surface[i] = surface;
  };
  const auto ask_alone = [&](int i) {
    if (const auto hit = FirstHit(rays.At(i), rays.t_min[i], t_max[i])) {
      take(i, hit->triangle, hit->t);
    }
  };
  if (const int lane = OnlyLane(valid); lane >= 0) return ask_alone(lane);

  FramedPacket framed;
  ToFrame(rays, valid, t_max, rays.any_hit ? 0 : kSlack, impl_->frame, &framed);
  const double near = rays.any_hit ? 0 : kNear;
  EmbreeContext context;
  Intersect16(framed.valid, impl_->scene.get(), &context, &framed.rayhit);
  PacketCorners corners;
  TakeCorners(*impl_->mesh, framed, &corners);
  PacketPlanes planes;
  (HasAvx2() ? MeetPlanesAvx2 : MeetPlanesAnywhere)(rays, corners, &planes);
  for (int i = 0; i < kPacketRays; ++i) {
    if (framed.valid[i] == 0 || framed.rayhit.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    // Well within the triangle in double precision, too, and not so near that another one might
    // lie before it: that is nearly always so.
    const bool is_clear = planes.least[i] > 1e-9 * planes.det[i] && planes.t[i] < t_max[i] &&
                          (planes.t[i] - rays.t_min[i]) * framed.per_t[i] > near;
    if (is_clear) {
      take(i, static_cast<int>(framed.rayhit.hit.primID[i]), planes.t[i]);
    } else {
      ask_alone(i);
    }
  }
}

}  // namespace lamella
