// Which triangle of a mesh does a ray meet first? Embree proposes in single precision, in the
// mesh's own frame; the corners decide in double precision.
#pragma once

#include <memory>
#include <optional>

#include "datasets_synthetic/mesh.h"
#include "datasets_synthetic/ray_packet.h"
#include "lightfield/ray_source.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace lamella {

struct TriangleHit {
  int triangle = 0;
  double t = 0;  // along the ray's direction, in its units
};

class EmbreeMesh {
 public:
  // `mesh` has triangles, passes CheckMesh and outlives this. MachineError where memory ends.
  EmbreeMesh(RTCDeviceTy* device, const Mesh& mesh);
  ~EmbreeMesh();
  EmbreeMesh(EmbreeMesh&&) noexcept;
  EmbreeMesh& operator=(EmbreeMesh&&) noexcept;

  // The first triangle at t in (t_min, t_max). t is that of the triangle's plane in double
  // precision. Triangles of no area (to 1e-14 of their sides' product) are never met. Where single
  // precision sees the ray pass a rim that double precision sees it miss by less than 1e-6 of the
  // mesh's radius, or the reverse, either may be answered. Safe to call from many threads.
  std::optional<TriangleHit> FirstHit(const Ray& ray, double t_min, double t_max) const;

  // For lanes with valid[i] != 0: the first triangle at t in (rays.t_min, t_max), both per lane.
  // hits->surface[i] becomes `surface` where one is met, else it is left as it was.
  void FirstHits(const RayPacket& rays, const int* valid, const double* t_max, int surface,
                 PacketHits* hits) const;

  // For benchmarks: Embree's scene, whose coordinates are (point - centre) / radius.
  RTCSceneTy* scene() const;
  Eigen::Vector3d centre() const;
  double radius() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Throws the MachineError that fits what Embree last complained of; nothing where it did not.
void ThrowEmbreeError(RTCDeviceTy* device);

}  // namespace lamella
