// Stanford .ply (G. Turk, "The PLY polygon file format", 1994).
#pragma once

#include <string>
#include <string_view>

#include "datasets_synthetic/mesh.h"

namespace lamella {

// `name` is for errors. Properties and elements that a mesh does not need are passed over.
Mesh ParsePly(std::string_view text, const std::string& name);

}  // namespace lamella
