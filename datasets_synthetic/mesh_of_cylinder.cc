#include "datasets_synthetic/mesh_of_cylinder.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void Add(Mesh& mesh, const Vector3d& vertex, const Vector3d& normal, const Vector2d& uv) {
  mesh.vertices.push_back(vertex);
  mesh.normals.push_back(normal);
  mesh.texture_coordinates.push_back(uv);
}

void AddCap(Mesh& mesh, const Vector3d& middle, const Vector3d& outwards, double v,
            const std::vector<Vector3d>& rim) {
  const int first = static_cast<int>(mesh.vertices.size());
  Add(mesh, middle, outwards, {0.5, v});
  const int n = static_cast<int>(rim.size()) - 1;  // the last one is the first one again
  for (int i = 0; i <= n; ++i) {
    Add(mesh, middle + rim[static_cast<std::size_t>(i)], outwards, {static_cast<double>(i) / n, v});
  }
  for (int i = 1; i <= n; ++i) mesh.triangles.push_back({first, first + i, first + i + 1});
}

}  // namespace

Mesh MeshOfCylinder(const Vector3d& from, const Vector3d& to, double radius, int n) {
  const Vector3d axis = (to - from).normalized();
  const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  std::vector<Vector3d> rim;
  for (int i = 0; i <= n; ++i) {
    const double angle = 2 * std::numbers::pi * (i % n) / n;
    rim.push_back(radius * (std::cos(angle) * x + std::sin(angle) * y));
  }
  Mesh mesh;
  for (int i = 0; i <= n; ++i) {
    const Vector3d& out = rim[static_cast<std::size_t>(i)];
    const double u = static_cast<double>(i) / n;
    Add(mesh, from + out, out.normalized(), {u, 0});
    Add(mesh, to + out, out.normalized(), {u, 1});
  }
  for (int i = 0; i < n; ++i) {
    const int k = 2 * i;
    mesh.triangles.push_back({k, k + 2, k + 3});
    mesh.triangles.push_back({k, k + 3, k + 1});
  }
  AddCap(mesh, from, -axis, 0, rim);
  AddCap(mesh, to, axis, 1, rim);
  return mesh;
}

}  // namespace lamella
