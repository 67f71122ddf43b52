#include <algorithm>
#include <cctype>
#include <string>

#include <fmt/format.h>

#include "datasets_synthetic/mesh.h"
#include "datasets_synthetic/mesh_obj.h"
#include "datasets_synthetic/mesh_ply.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"

namespace lamella {

Mesh ReadMesh(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".obj" && extension != ".ply") {
    throw InputError(path.string(), fmt::format("\"{}\" is no known format of meshes", extension),
                     "use .obj or .ply");
  }
  const std::string text = ReadText(path);
  return extension == ".obj" ? ParseObj(text, path.string()) : ParsePly(text, path.string());
}

}  // namespace lamella
