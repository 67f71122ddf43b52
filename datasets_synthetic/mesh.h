// Triangle meshes: from files, from generators, for scenes.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace lamella {

// Seen from both sides. Triangles of no area are allowed and never seen.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;             // finite
  std::vector<Eigen::Vector3i> triangles;            // indices of vertices
  std::vector<Eigen::Vector2d> texture_coordinates;  // per vertex, u right, v up; or empty
  std::vector<Eigen::Vector3d> normals;              // per vertex, unit; or empty: faceted
};

// InputError where an index or a list's length does not fit or a number is not finite; `where`
// names the mesh.
void CheckMesh(const Mesh& mesh, const std::string& where);

// Wavefront .obj (v, vt, vn, f; anything else is passed over; polygons become fans) and Stanford
// .ply (ascii, binary of either byte order; vertex x y z [nx ny nz] [u v | s t], face
// vertex_indices). What is not finite, out of range, cut short or not understood is an InputError
// with file, line (binary: byte) and reason.
Mesh ReadMesh(const std::filesystem::path& path);

Eigen::AlignedBox3d BoundsOf(const Mesh& mesh);

// Normals follow the inverse transpose; a mirroring map turns no triangle round.
Mesh Transformed(const Mesh& mesh, const Eigen::Affine3d& map);

// n rings from pole to pole (>= 2) of 2 n segments; u is longitude, v latitude; smooth normals.
Mesh MeshOfSphere(const Eigen::Vector3d& centre, double radius, int n);

// About the axis y: a tube of radius `tube` whose centre runs at `radius`; n segments round the
// tube, 3 n round the axis (n >= 3); smooth normals.
Mesh MeshOfTorus(const Eigen::Vector3d& centre, double radius, double tube, int n);

// z = height(x, y) on a grid of columns x rows cells over [x0, x0 + size_x] x [y0, y0 + size_y],
// two triangles a cell; (u, v) run over [0, 1]^2 with x and y; faceted.
struct HeightField {
  double x0 = 0, y0 = 0, size_x = 1, size_y = 1;
  int columns = 1, rows = 1;
};
Mesh MeshOfHeightField(const HeightField& field,
                       const std::function<double(double x, double y)>& height);

}  // namespace lamella
