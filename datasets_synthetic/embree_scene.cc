#include "datasets_synthetic/embree_scene.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "datasets_synthetic/embree_api-inl.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What the callback needs besides Embree's own rays. Embree hands the context through.
struct PacketQuery {
  EmbreeContext context;  // first, so that a pointer to it is a pointer to the query
  const RayPacket* rays = nullptr;
  const double* t_start = nullptr;
  const double* per_t = nullptr;
  PacketHits* hits = nullptr;
};

// Where two t are the same, but for the rounding of what they were computed from.
double SameWithin(double t, double per_t) { return 1e-12 * std::abs(t) + 1e-15 / per_t; }

bool IsNearer(double t, int surface, const PacketHits& best, int i, double per_t) {
  if (best.surface[i] < 0) return true;
  const double same = SameWithin(best.t[i], per_t);
  return t < best.t[i] - same || (t <= best.t[i] + same && surface < best.surface[i]);
}

DevicePtr NewDevice() {
  DevicePtr device(rtcNewDevice(nullptr));
  if (device) return device;
  throw MachineError("",
                     "Embree can't be started (error " +
                         std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))) + ")",
                     "check free memory and the package libembree3-3");
}

}  // namespace

struct EmbreeScene::Impl {
  struct Part {
    const Shape* shape = nullptr;
    AlignedBox3d bounds;
    std::optional<EmbreeMesh> mesh;
    int surface = 0;
  };
  std::vector<double> sizes;         // of all surfaces
  std::vector<const Part*> part_of;  // of a surface; null: nothing to meet
  DevicePtr device;
  std::vector<Part> parts;  // what there is to meet, in the order of the surfaces
  Frame frame;
  ScenePtr scene;

  static void Bounds(const RTCBoundsFunctionArguments* arguments);
  static void AskPart(const RTCIntersectFunctionNArguments* arguments);
  void Build();
};

void EmbreeScene::Impl::Bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& impl = *static_cast<const Impl*>(arguments->geometryUserPtr);
  const AlignedBox3d& box = impl.parts[arguments->primID].bounds;
  const Vector3d lower = (box.min() - impl.frame.centre) / impl.frame.radius;
  const Vector3d upper = (box.max() - impl.frame.centre) / impl.frame.radius;
  RTCBounds& out = *arguments->bounds_o;
  out.lower_x = RoundDown(lower.x());
  out.lower_y = RoundDown(lower.y());
  out.lower_z = RoundDown(lower.z());
  out.upper_x = RoundUp(upper.x());
  out.upper_y = RoundUp(upper.y());
  out.upper_z = RoundUp(upper.z());
}

namespace {

// Lanes of `valid` whose ray meets the shape get its t.
void AskShape(const Shape& shape, const RayPacket& rays, const int* valid, int surface,
              PacketHits* hits) {
  for (int i = 0; i < kPacketRays; ++i) {
    if (valid[i] == 0) continue;
    const Ray ray = rays.At(i);
    const auto* sphere = std::get_if<Sphere>(&shape);
    const std::optional<double> t =
        sphere != nullptr
            ? Intersect(*sphere, ray, rays.t_min[i], rays.t_max[i])
            : Intersect(std::get<Parallelogram>(shape), ray, rays.t_min[i], rays.t_max[i]);
    if (!t) continue;
    hits->t[i] = *t;
    hits->surface[i] = surface;
    hits->triangle[i] = 0;
  }
}

}  // namespace

// Embree may split a packet: the rays' ids say which of ours are asked.
void EmbreeScene::Impl::AskPart(const RTCIntersectFunctionNArguments* arguments) {
  const auto& impl = *static_cast<const Impl*>(arguments->geometryUserPtr);
  const auto& query = *reinterpret_cast<const PacketQuery*>(arguments->context);
  const Part& part = impl.parts[arguments->primID];
  PacketHits& best = *query.hits;
  RTCRayN* const rays = RTCRayHitN_RayN(arguments->rayhit, arguments->N);
  alignas(64) int valid[kPacketRays] = {};
  for (unsigned lane = 0; lane < arguments->N; ++lane) {
    if (arguments->valid[lane] != 0) valid[RTCRayN_id(rays, arguments->N, lane)] = -1;
  }
  PacketHits found;
  std::fill(std::begin(found.surface), std::end(found.surface), -1);
  if (part.mesh) {
    alignas(64) double t_max[kPacketRays];  // nothing is asked for behind what was found
    for (int i = 0; i < kPacketRays; ++i) {
      t_max[i] = best.surface[i] < 0 ? query.rays->t_max[i]
                                     : best.t[i] + 2 * SameWithin(best.t[i], query.per_t[i]);
    }
    part.mesh->FirstHits(*query.rays, valid, t_max, part.surface, &found);
  } else {
    AskShape(*part.shape, *query.rays, valid, part.surface, &found);
  }
  for (unsigned lane = 0; lane < arguments->N; ++lane) {
    if (arguments->valid[lane] == 0) continue;
    const auto i = static_cast<int>(RTCRayN_id(rays, arguments->N, lane));
    if (found.surface[i] < 0 || !IsNearer(found.t[i], part.surface, best, i, query.per_t[i])) {
      continue;
    }
    best.t[i] = found.t[i];
    best.surface[i] = found.surface[i];
    best.triangle[i] = found.triangle[i];
    // Rounded up: surfaces that are as near in single precision are still asked.
    const double far = (found.t[i] - query.t_start[i]) * query.per_t[i];
    RTCRayN_tfar(rays, arguments->N, lane) = std::max(0.0F, RoundUp(far));
    RTCHitN* const hit = RTCRayHitN_HitN(arguments->rayhit, arguments->N);
    RTCHitN_primID(hit, arguments->N, lane) = arguments->primID;
    RTCHitN_geomID(hit, arguments->N, lane) = arguments->geomID;
  }
}

void EmbreeScene::Impl::Build() {
  AlignedBox3d all;
  for (const Part& part : parts) all.extend(part.bounds);
  frame.centre = 0.5 * all.min() + 0.5 * all.max();
  frame.radius = std::max(0.5 * (all.max() - all.min()).norm(), std::numeric_limits<double>::min());
  scene.reset(rtcNewScene(device.get()));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(parts.size()));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(geometry, &Impl::Bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, &Impl::AskPart);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  ThrowEmbreeError(device.get());
}

EmbreeScene::EmbreeScene(std::vector<const Shape*> shapes) : impl_(std::make_unique<Impl>()) {
  const FlushDenormals flush;
  impl_->parts.reserve(shapes.size());
  impl_->part_of.assign(shapes.size(), nullptr);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const AlignedBox3d bounds = BoundsOf(*shapes[i]);
    impl_->sizes.push_back(bounds.isEmpty() ? 0 : 0.5 * (bounds.max() - bounds.min()).norm());
    const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(shapes[i]);
    if (mesh != nullptr && (*mesh)->triangles.empty()) continue;
    if (!impl_->device) impl_->device = NewDevice();
    Impl::Part& part = impl_->parts.emplace_back();
    part.shape = shapes[i];
    part.bounds = bounds;
    part.surface = static_cast<int>(i);
    if (mesh != nullptr) part.mesh.emplace(impl_->device.get(), **mesh);
    impl_->part_of[i] = &part;
  }
  if (!impl_->parts.empty()) impl_->Build();
}

EmbreeScene::~EmbreeScene() = default;
EmbreeScene::EmbreeScene(EmbreeScene&&) noexcept = default;
EmbreeScene& EmbreeScene::operator=(EmbreeScene&&) noexcept = default;

double EmbreeScene::SizeOf(int surface) const {
  return impl_->sizes[static_cast<std::size_t>(surface)];
}

const EmbreeMesh* EmbreeScene::MeshOf(int surface) const {
  const Impl::Part* part = impl_->part_of[static_cast<std::size_t>(surface)];
  return part != nullptr && part->mesh ? &*part->mesh : nullptr;
}

std::optional<SurfaceHit> EmbreeScene::FirstHit(const Ray& ray, double t_min) const {
  if (impl_->parts.empty()) return std::nullopt;
  FramedRay framed;
  if (!ToFrame(ray, t_min, kInfinity, 0, impl_->frame, &framed)) return std::nullopt;
  // A packet of which Embree's one ray asks the first lane.
  RayPacket rays{};
  for (int axis = 0; axis < 3; ++axis) {
    rays.origin[axis][0] = ray.origin(axis);
    rays.direction[axis][0] = ray.direction(axis);
  }
  rays.t_min[0] = t_min;
  rays.t_max[0] = kInfinity;
  PacketHits hits;
  std::fill(std::begin(hits.surface), std::end(hits.surface), -1);
  double t_start[kPacketRays] = {framed.t_start}, per_t[kPacketRays] = {framed.per_t};
  PacketQuery query;
  query.rays = &rays;
  query.t_start = t_start;
  query.per_t = per_t;
  query.hits = &hits;
  const FlushDenormals flush;
  Intersect1(impl_->scene.get(), &query.context, nullptr, &framed.rayhit);
  if (hits.surface[0] < 0) return std::nullopt;
  return SurfaceHit{hits.surface[0], hits.t[0], hits.triangle[0]};
}

void EmbreeScene::FirstHits(const RayPacket& rays, PacketHits* hits) const {
  std::fill(std::begin(hits->surface), std::end(hits->surface), -1);
  if (impl_->parts.empty()) return;
  const FlushDenormals flush;
  if (impl_->parts.size() == 1 && impl_->parts[0].mesh) {
    impl_->parts[0].mesh->FirstHits(rays, rays.active, rays.t_max, impl_->parts[0].surface, hits);
    return;
  }
  FramedPacket framed;
  ToFrame(rays, rays.active, rays.t_max, 0, impl_->frame, &framed);
  PacketQuery query;
  query.rays = &rays;
  query.t_start = framed.t_start;
  query.per_t = framed.per_t;
  query.hits = hits;
  Intersect16(framed.valid, impl_->scene.get(), &query.context, &framed.rayhit);
}

}  // namespace lamella
