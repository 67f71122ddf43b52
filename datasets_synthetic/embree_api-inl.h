// Embree, whichever version: for the .cc files that trace rays only.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include <immintrin.h>

// Debian 12 has Embree 3.13; Embree 4 moved the context of a query into optional arguments.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "datasets_synthetic/ray_packet.h"

namespace lamella {

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
using EmbreeContext = RTCRayQueryContext;
constexpr RTCSceneFlags kFilterPerQuery = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
inline RTCIntersectArguments ArgumentsOf(EmbreeContext* context) {
  rtcInitRayQueryContext(context);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = context;
  return arguments;
}
// `filter` is asked of every candidate on a triangle; null: none.
inline void Intersect1(RTCScene scene, EmbreeContext* context, RTCFilterFunctionN filter,
                       RTCRayHit* rayhit) {
  RTCIntersectArguments arguments = ArgumentsOf(context);
  arguments.filter = filter;
  if (filter != nullptr) arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  rtcIntersect1(scene, rayhit, &arguments);
}
inline void Intersect16(const int* valid, RTCScene scene, EmbreeContext* context,
                        RTCRayHit16* rayhit) {
  RTCIntersectArguments arguments = ArgumentsOf(context);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene, rayhit, &arguments);
}
#else
using EmbreeContext = RTCIntersectContext;
constexpr RTCSceneFlags kFilterPerQuery = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
inline void Intersect1(RTCScene scene, EmbreeContext* context, RTCFilterFunctionN filter,
                       RTCRayHit* rayhit) {
  rtcInitIntersectContext(context);
  context->filter = filter;
  rtcIntersect1(scene, context, rayhit);
}
inline void Intersect16(const int* valid, RTCScene scene, EmbreeContext* context,
                        RTCRayHit16* rayhit) {
  rtcInitIntersectContext(context);
  context->flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene, context, rayhit);
}
#endif

// Outwards to the next float and a little further, so that nothing is lost at a boundary.
inline float RoundUp(double value) {
  return static_cast<float>(value + 1e-6 * std::abs(value) + 5e-7);
}
inline float RoundDown(double value) { return -RoundUp(-value); }

// Embree's coordinates are (point - centre) / radius: single precision then suffices to find
// candidates wherever a scene or mesh lies and however large it is.
struct Frame {
  Eigen::Vector3d centre{0, 0, 0};
  double radius = 1;
};

// Embree's rays and how their t follows from ours: (t - t_start) * per_t.
struct FramedRay {
  RTCRayHit rayhit{};
  double t_start = 0, per_t = 1;
};
struct FramedPacket {
  RTCRayHit16 rayhit;
  alignas(64) double t_start[kPacketRays];
  alignas(64) double per_t[kPacketRays];
  alignas(64) int valid[kPacketRays];
};

// Rays start `back` radii before t_min (candidates of single precision may lie that far off), but
// not farther from the centre than 1.01 radii along the ray, where digits would be wasted. False
// (not valid) where the direction is no direction.
inline bool ToFrame(const Ray& ray, double t_min, double t_max, double back, const Frame& frame,
                    FramedRay* framed) {
  const Eigen::Vector3d to_centre = frame.centre - ray.origin;
  const double length2 = ray.direction.squaredNorm();
  if (!(length2 > 0) || !std::isfinite(length2)) return false;
  const double per_length = 1 / std::sqrt(length2), t_radius = frame.radius * per_length;
  const double t_closest = to_centre.dot(ray.direction) * per_length * per_length;
  framed->t_start = std::max(t_min - back * t_radius, t_closest - 1.01 * t_radius);
  framed->per_t = 1 / t_radius;
  const Eigen::Vector3d start = (framed->t_start * ray.direction - to_centre) * (1 / frame.radius);
  const Eigen::Vector3d direction = ray.direction * per_length;
  RTCRay& out = framed->rayhit.ray;
  out.org_x = static_cast<float>(start.x());
  out.org_y = static_cast<float>(start.y());
  out.org_z = static_cast<float>(start.z());
  out.dir_x = static_cast<float>(direction.x());
  out.dir_y = static_cast<float>(direction.y());
  out.dir_z = static_cast<float>(direction.z());
  out.tnear = 0;
  out.tfar = RoundUp((t_max - framed->t_start) * framed->per_t);
  out.mask = ~0U;
  framed->rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  framed->rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return out.tfar > 0;
}

// The same for lanes of a packet, `active` of them.
void ToFrame(const RayPacket& rays, const int* active, const double* t_max, double back,
             const Frame& frame, FramedPacket* framed);

// A loop over lanes, compiled for whatever x86-64 runs it and once more for AVX2, which is taken
// where there is. Products and sums are rounded one by one in both: the results are the same.
#define LAMELLA_LANES __attribute__((always_inline)) inline
#define LAMELLA_AVX2 __attribute__((target("avx2")))
inline bool HasAvx2() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

}  // namespace lamella
