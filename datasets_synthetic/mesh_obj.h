// Wavefront .obj, as far as it is geometry (Wavefront, "Advanced Visualizer manual", appendix B1).
#pragma once

#include <string>
#include <string_view>

#include "datasets_synthetic/mesh.h"

namespace lamella {

// `name` is for errors. A vertex that faces use with several texture coordinates or normals becomes
// several vertices.
Mesh ParseObj(std::string_view text, const std::string& name);

}  // namespace lamella
