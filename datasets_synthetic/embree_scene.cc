#include "datasets_synthetic/embree_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <immintrin.h>

// Debian 12 has Embree 3.13; Embree 4 dropped the context of a query for optional arguments.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Embree is meant to run with denormals flushed; nobody else's arithmetic may notice.
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040); }  // FTZ | DAZ
  ~FlushDenormals() { _mm_setcsr(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_;
};

struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DevicePtr = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using ScenePtr = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

#if RTC_VERSION_MAJOR >= 4
using Context = RTCRayQueryContext;
void InitContext(Context* context) { rtcInitRayQueryContext(context); }
void Intersect(RTCScene scene, Context* context, RTCRayHit* rayhit) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = context;
  rtcIntersect1(scene, rayhit, &arguments);
}
#else
using Context = RTCIntersectContext;
void InitContext(Context* context) { rtcInitIntersectContext(context); }
void Intersect(RTCScene scene, Context* context, RTCRayHit* rayhit) {
  rtcIntersect1(scene, context, rayhit);
}
#endif

// What the callback needs besides Embree's own ray. Embree hands the context through.
struct Query {
  Context context;  // first, so that a pointer to it is a pointer to the query
  const Ray* ray = nullptr;
  double t_min = 0;
  double t_offset = 0, t_scale = 1;  // Embree's t = (t - t_offset) * t_scale
  std::optional<SurfaceHit> best;
};

// Outwards to the next float and a little further, so that nothing is lost at a boundary.
float RoundUp(double value) { return static_cast<float>(value + 1e-6 * std::abs(value) + 1e-7); }
float RoundDown(double value) { return -RoundUp(-value); }

}  // namespace

struct EmbreeScene::Impl {
  std::vector<AlignedBox3d> bounds;
  SurfaceIntersection intersection;
  // Embree's coordinates are (point - centre) / radius: single precision then suffices to find
  // candidates wherever the scene lies and however large it is.
  Vector3d centre = Vector3d::Zero();
  double radius = 1;
  DevicePtr device;
  ScenePtr scene;

  static void Bounds(const RTCBoundsFunctionArguments* arguments);
  static void IntersectOne(const RTCIntersectFunctionNArguments* arguments);
  std::optional<std::pair<double, double>> ClipToScene(const Ray& ray, double t_min) const;
};

void EmbreeScene::Impl::Bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& impl = *static_cast<const Impl*>(arguments->geometryUserPtr);
  const AlignedBox3d& box = impl.bounds[arguments->primID];
  const Vector3d lower = (box.min() - impl.centre) / impl.radius;
  const Vector3d upper = (box.max() - impl.centre) / impl.radius;
  RTCBounds& out = *arguments->bounds_o;
  out.lower_x = RoundDown(lower.x());
  out.lower_y = RoundDown(lower.y());
  out.lower_z = RoundDown(lower.z());
  out.upper_x = RoundUp(upper.x());
  out.upper_y = RoundUp(upper.y());
  out.upper_z = RoundUp(upper.z());
}

void EmbreeScene::Impl::IntersectOne(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  const auto& impl = *static_cast<const Impl*>(arguments->geometryUserPtr);
  auto& query = *reinterpret_cast<Query*>(arguments->context);
  const int index = static_cast<int>(arguments->primID);
  const std::optional<double> t = impl.intersection(index, *query.ray, query.t_min, kInfinity);
  if (!t) return;
  const bool nearer =
      !query.best || *t < query.best->t || (*t == query.best->t && index < query.best->surface);
  if (!nearer) return;
  query.best = SurfaceHit{index, *t};
  // Rounded up: surfaces that are as near in single precision are still asked.
  auto& rayhit = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  rayhit.ray.tfar = std::max(0.0F, RoundUp((*t - query.t_offset) * query.t_scale));
  rayhit.hit.primID = arguments->primID;
  rayhit.hit.geomID = arguments->geomID;
}

// The part of the ray within the sphere about the scene, from t_min on.
std::optional<std::pair<double, double>> EmbreeScene::Impl::ClipToScene(const Ray& ray,
                                                                        double t_min) const {
  const double length2 = ray.direction.squaredNorm();
  if (!(length2 > 0) || !std::isfinite(length2)) return std::nullopt;
  const double t_closest = (centre - ray.origin).dot(ray.direction) / length2;
  const Vector3d closest = ray.origin + t_closest * ray.direction - centre;
  const double half2 = 1.01 * 1.01 * radius * radius - closest.squaredNorm();
  if (!(half2 > 0)) return std::nullopt;
  const double half = std::sqrt(half2 / length2);
  const double first = std::max(t_min, t_closest - half), last = t_closest + half;
  if (!(first < last)) return std::nullopt;
  return std::pair(first, last);
}

EmbreeScene::EmbreeScene(std::vector<AlignedBox3d> bounds, SurfaceIntersection intersection)
    : impl_(std::make_unique<Impl>()) {
  impl_->bounds = std::move(bounds);
  impl_->intersection = std::move(intersection);
  if (impl_->bounds.empty()) return;
  AlignedBox3d all;
  for (const AlignedBox3d& box : impl_->bounds) all.extend(box);
  impl_->centre = all.center();
  impl_->radius = std::max(0.5 * all.diagonal().norm(), std::numeric_limits<double>::min());

  const FlushDenormals flush;
  impl_->device.reset(rtcNewDevice(nullptr));
  if (!impl_->device) {
    throw MachineError("",
                       "Embree can't be started (error " +
                           std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))) + ")",
                       "check free memory and the package libembree3-3");
  }
  impl_->scene.reset(rtcNewScene(impl_->device.get()));
  rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(impl_->device.get(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(impl_->bounds.size()));
  rtcSetGeometryUserData(geometry, impl_.get());
  rtcSetGeometryBoundsFunction(geometry, &Impl::Bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, &Impl::IntersectOne);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene.get());
  const RTCError error = rtcGetDeviceError(impl_->device.get());
  if (error != RTC_ERROR_NONE) {
    throw MachineError(
        "", "Embree can't build the scene (error " + std::to_string(static_cast<int>(error)) + ")",
        "use a smaller scene or free some memory");
  }
}

EmbreeScene::~EmbreeScene() = default;
EmbreeScene::EmbreeScene(EmbreeScene&&) noexcept = default;
EmbreeScene& EmbreeScene::operator=(EmbreeScene&&) noexcept = default;

std::optional<SurfaceHit> EmbreeScene::FirstHit(const Ray& ray, double t_min) const {
  if (impl_->bounds.empty()) return std::nullopt;
  const auto clipped = impl_->ClipToScene(ray, t_min);
  if (!clipped) return std::nullopt;
  const auto [first, last] = *clipped;
  const double length = ray.direction.norm();
  const Vector3d origin = (ray.origin + first * ray.direction - impl_->centre) / impl_->radius;
  const Vector3d direction = ray.direction / length;

  Query query;
  InitContext(&query.context);
  query.ray = &ray;
  query.t_min = t_min;
  query.t_offset = first;
  query.t_scale = length / impl_->radius;

  RTCRayHit rayhit{};
  rayhit.ray.org_x = static_cast<float>(origin.x());
  rayhit.ray.org_y = static_cast<float>(origin.y());
  rayhit.ray.org_z = static_cast<float>(origin.z());
  rayhit.ray.dir_x = static_cast<float>(direction.x());
  rayhit.ray.dir_y = static_cast<float>(direction.y());
  rayhit.ray.dir_z = static_cast<float>(direction.z());
  rayhit.ray.tnear = 0;
  rayhit.ray.tfar = RoundUp((last - first) * query.t_scale);
  rayhit.ray.mask = ~0U;
  rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  const FlushDenormals flush;
  Intersect(impl_->scene.get(), &query.context, &rayhit);
  return query.best;
}

}  // namespace lamella
