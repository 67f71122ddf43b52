// distribute/displays/*.toml as text; displays_embedded.cc is made by CMake.
#pragma once

#include <string_view>
#include <vector>

namespace lamella {

struct EmbeddedDisplay {
  std::string_view name, toml;
};
const std::vector<EmbeddedDisplay>& EmbeddedDisplays();  // by name

}  // namespace lamella
