#include "datasets_synthetic/mesh.h"

#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

// Two triangles a cell of a grid of vertices whose rows are `stride` apart; a pole's triangle of no
// area is left out.
void AddCell(Mesh* mesh, int first, int stride, bool lower, bool upper) {
  if (lower) mesh->triangles.emplace_back(first, first + 1, first + stride + 1);
  if (upper) mesh->triangles.emplace_back(first, first + stride + 1, first + stride);
}

double Turn(int i, int n) { return 2 * std::numbers::pi * (i % n) / n; }  // closes exactly

}  // namespace

void CheckMesh(const Mesh& mesh, const std::string& where) {
  const auto fail = [&](const std::string& what) {
    throw InputError(where, what, "repair the mesh");
  };
  const std::size_t count = mesh.vertices.size();
  if (!mesh.texture_coordinates.empty() && mesh.texture_coordinates.size() != count) {
    fail(fmt::format("{} texture coordinates for {} vertices", mesh.texture_coordinates.size(),
                     count));
  }
  if (!mesh.normals.empty() && mesh.normals.size() != count) {
    fail(fmt::format("{} normals for {} vertices", mesh.normals.size(), count));
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!mesh.vertices[i].allFinite()) fail(fmt::format("vertex {} is not finite", i));
    if (!mesh.texture_coordinates.empty() && !mesh.texture_coordinates[i].allFinite()) {
      fail(fmt::format("the texture coordinates of vertex {} are not finite", i));
    }
    if (!mesh.normals.empty() && !mesh.normals[i].allFinite()) {
      fail(fmt::format("the normal of vertex {} is not finite", i));
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const int index : mesh.triangles[i]) {
      if (index < 0 || static_cast<std::size_t>(index) >= count) {
        fail(fmt::format("triangle {} asks for vertex {} of {}", i, index, count));
      }
    }
  }
}

Eigen::AlignedBox3d BoundsOf(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

Mesh Transformed(const Mesh& mesh, const Eigen::Affine3d& map) {
  Mesh moved = mesh;
  for (Vector3d& vertex : moved.vertices) vertex = map * vertex;
  const Eigen::Matrix3d of_normals = map.linear().inverse().transpose();
  for (Vector3d& normal : moved.normals) normal = (of_normals * normal).normalized();
  return moved;
}

Mesh MeshOfSphere(const Vector3d& centre, double radius, int n) {
  Mesh mesh;
  const int segments = 2 * n;
  for (int i = 0; i <= n; ++i) {
    const double latitude = std::numbers::pi * (static_cast<double>(i) / n - 0.5);
    const double ring = i == 0 || i == n ? 0 : std::cos(latitude);
    for (int j = 0; j <= segments; ++j) {
      const double turn = Turn(j, segments) - std::numbers::pi;
      const Vector3d normal =
          Vector3d(ring * std::sin(turn), std::sin(latitude), ring * std::cos(turn)).normalized();
      mesh.vertices.emplace_back(centre + radius * normal);
      mesh.normals.push_back(normal);
      mesh.texture_coordinates.emplace_back(static_cast<double>(j) / segments,
                                            static_cast<double>(i) / n);
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < segments; ++j) {
      AddCell(&mesh, i * (segments + 1) + j, segments + 1, i > 0, i < n - 1);
    }
  }
  return mesh;
}

Mesh MeshOfTorus(const Vector3d& centre, double radius, double tube, int n) {
  Mesh mesh;
  const int round = 3 * n;
  for (int i = 0; i <= n; ++i) {
    const double across = Turn(i, n);
    for (int j = 0; j <= round; ++j) {
      const double along = Turn(j, round);
      const Vector3d outwards(std::sin(along), 0, std::cos(along));
      const Vector3d normal = std::cos(across) * outwards + Vector3d(0, std::sin(across), 0);
      mesh.vertices.emplace_back(centre + radius * outwards + tube * normal);
      mesh.normals.push_back(normal);
      mesh.texture_coordinates.emplace_back(static_cast<double>(j) / round,
                                            static_cast<double>(i) / n);
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < round; ++j) AddCell(&mesh, i * (round + 1) + j, round + 1, true, true);
  }
  return mesh;
}

Mesh MeshOfHeightField(const HeightField& field,
                       const std::function<double(double x, double y)>& height) {
  Mesh mesh;
  const auto columns = static_cast<std::size_t>(field.columns);
  const auto rows = static_cast<std::size_t>(field.rows);
  mesh.vertices.reserve((columns + 1) * (rows + 1));
  mesh.texture_coordinates.reserve((columns + 1) * (rows + 1));
  mesh.triangles.reserve(2 * columns * rows);
  for (int j = 0; j <= field.rows; ++j) {
    for (int i = 0; i <= field.columns; ++i) {
      const double u = static_cast<double>(i) / field.columns;
      const double v = static_cast<double>(j) / field.rows;
      const double x = field.x0 + u * field.size_x, y = field.y0 + v * field.size_y;
      mesh.vertices.emplace_back(x, y, height(x, y));
      mesh.texture_coordinates.emplace_back(u, v);
    }
  }
  for (int j = 0; j < field.rows; ++j) {
    for (int i = 0; i < field.columns; ++i) {
      AddCell(&mesh, j * (field.columns + 1) + i, field.columns + 1, true, true);
    }
  }
  return mesh;
}

}  // namespace lamella
