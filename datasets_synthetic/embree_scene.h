// Which of many surfaces does a ray meet first? Embree finds the candidates in single precision,
// the surfaces' own equations and corners decide in double precision.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "datasets_synthetic/embree_mesh.h"
#include "datasets_synthetic/ray_packet.h"
#include "datasets_synthetic/shapes.h"
#include "lightfield/ray_source.h"

namespace lamella {

struct SurfaceHit {
  int surface = 0;
  double t = 0;      // along the ray's direction, in its units
  int triangle = 0;  // of a mesh
};

// One Embree scene of all surfaces' boxes; within its box a shape is asked by its equation, a mesh
// through an Embree scene of its own. So every mesh has the whole of single precision for itself,
// and surfaces of very different sizes and distances don't disturb each other.
class EmbreeScene {
 public:
  // Keeps the pointers: the shapes must outlive this. Meshes pass CheckMesh; those without
  // triangles are never met. MachineError where Embree can't be set up.
  explicit EmbreeScene(std::vector<const Shape*> shapes);
  ~EmbreeScene();
  EmbreeScene(EmbreeScene&&) noexcept;
  EmbreeScene& operator=(EmbreeScene&&) noexcept;

  // The first surface with t > t_min (which may be -infinity: from the viewer's side of a parallel
  // projection). Of surfaces at one t (to 1e-12 of it) the first in the list is met, so the answer
  // never depends on how Embree built its tree. Safe to call from many threads; the caller's
  // floating-point modes are kept.
  std::optional<SurfaceHit> FirstHit(const Ray& ray, double t_min) const;

  // The same for the active rays of a packet, each within its own range of t. Rays that have their
  // origin or direction in common are fastest.
  void FirstHits(const RayPacket& rays, PacketHits* hits) const;

  // Half the diagonal of the surface's bounds.
  double SizeOf(int surface) const;
  // Null where the surface is no mesh, or one without triangles.
  const EmbreeMesh* MeshOf(int surface) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lamella
