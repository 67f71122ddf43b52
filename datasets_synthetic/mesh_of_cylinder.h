// Rods, posts and wires.
#pragma once

#include <Eigen/Core>

#include "datasets_synthetic/mesh.h"

namespace lamella {

// A cylinder with caps, its axis from one point to another one that differs; n segments round it
// (n >= 3); smooth normals on the side, u round the axis, v along it.
Mesh MeshOfCylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, int n);

}  // namespace lamella
