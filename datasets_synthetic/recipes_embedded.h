// datasets_synthetic/recipes/*.toml as text; recipes_embedded.cc is made by CMake.
#pragma once

#include <string_view>
#include <vector>

namespace lamella {

struct EmbeddedRecipe {
  std::string_view name, toml;
};
const std::vector<EmbeddedRecipe>& EmbeddedRecipes();  // by name

}  // namespace lamella
