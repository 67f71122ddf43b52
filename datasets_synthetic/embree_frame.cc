#include <cmath>

#include "datasets_synthetic/embree_api-inl.h"

namespace lamella {
namespace {

LAMELLA_LANES void FrameLanes(const RayPacket& __restrict rays, const double* __restrict t_max,
                              double back, const double* __restrict centre, double radius,
                              FramedPacket* __restrict framed) {
  const double per_radius = 1 / radius, cx = centre[0], cy = centre[1], cz = centre[2];
  RTCRay16& out = framed->rayhit.ray;
  for (int i = 0; i < kPacketRays; ++i) {
    const double dx = rays.direction[0][i], dy = rays.direction[1][i], dz = rays.direction[2][i];
    const double x = cx - rays.origin[0][i], y = cy - rays.origin[1][i], z = cz - rays.origin[2][i];
    const double length2 = dx * dx + dy * dy + dz * dz;
    const double per_length = 1 / std::sqrt(length2), t_radius = radius * per_length;
    const double t_closest = (x * dx + y * dy + z * dz) * per_length * per_length;
    const double earliest = rays.t_min[i] - back * t_radius, near = t_closest - 1.01 * t_radius;
    const double t_start = earliest > near ? earliest : near;
    const double per_t = per_radius * length2 * per_length;
    framed->t_start[i] = t_start;
    framed->per_t[i] = per_t;
    out.org_x[i] = static_cast<float>((t_start * dx - x) * per_radius);
    out.org_y[i] = static_cast<float>((t_start * dy - y) * per_radius);
    out.org_z[i] = static_cast<float>((t_start * dz - z) * per_radius);
    out.dir_x[i] = static_cast<float>(dx * per_length);
    out.dir_y[i] = static_cast<float>(dy * per_length);
    out.dir_z[i] = static_cast<float>(dz * per_length);
    out.tfar[i] = static_cast<float>((t_max[i] - t_start) * per_t * (1 + 1e-6) + 5e-7);
  }
}

void FrameAnywhere(const RayPacket& rays, const double* t_max, double back, const double* centre,
                   double radius, FramedPacket* framed) {
  FrameLanes(rays, t_max, back, centre, radius, framed);
}
LAMELLA_AVX2 void FrameAvx2(const RayPacket& rays, const double* t_max, double back,
                            const double* centre, double radius, FramedPacket* framed) {
  FrameLanes(rays, t_max, back, centre, radius, framed);
}

}  // namespace

void ToFrame(const RayPacket& rays, const int* active, const double* t_max, double back,
             const Frame& frame, FramedPacket* framed) {
  (HasAvx2() ? FrameAvx2 : FrameAnywhere)(rays, t_max, back, frame.centre.data(), frame.radius,
                                          framed);
  RTCRayHit16& out = framed->rayhit;
  for (unsigned i = 0; i < kPacketRays; ++i) {
    out.ray.tnear[i] = 0;
    out.ray.time[i] = 0;
    out.ray.mask[i] = ~0U;
    out.ray.id[i] = i;
    out.ray.flags[i] = 0;
    out.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    out.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  // Neither a direction of length 0 or infinity nor an empty range has a tfar above 0.
  constexpr double kLargest = std::numeric_limits<double>::max();
  for (int i = 0; i < kPacketRays; ++i) {
    const bool is_ray = out.ray.tfar[i] > 0 && framed->per_t[i] > 0 && framed->per_t[i] <= kLargest;
    framed->valid[i] = is_ray ? active[i] : 0;
  }
}

}  // namespace lamella
