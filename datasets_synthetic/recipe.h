// Recipes: what to photograph and how, as a small TOML file (docs/formats.md). The scenes that the
// program knows by name are recipes that are built into it (datasets_synthetic/recipes/*.toml).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets_synthetic/cameras.h"
#include "datasets_synthetic/degrade.h"
#include "datasets_synthetic/scene.h"
#include "lightfield/options.h"

namespace lamella {

struct PhotographOptions {
  int supersampling = 4;       // rays per pixel and axis where surfaces meet
  std::string format = "jpg";  // or png (both 8 bits, sRGB), exr (float, linear)
};
OptionTable Describe(PhotographOptions& options);  // the table [photographs] of a recipe

struct Recipe {
  std::string name, description;
  std::uint32_t seed = 1;  // of textures, of unsteady cameras, of all degradation
  Scene scene;
  CameraLayout layout;
  Degradation degradation;
  PhotographOptions photographs;
  std::string scene_toml;  // the tables that `scene` came from; files by their absolute paths
};

// Files that the recipe names are relative to its folder. `seed` stands in for the recipe's own.
// UsageError with file and line where the recipe is wrong (unknown keys or names with the nearest
// known one, wrong types, numbers that are not finite or out of range); InputError with file and
// line where a mesh or a picture can't be read.
Recipe ReadRecipe(const std::filesystem::path& path, std::optional<std::uint32_t> seed = {});
Recipe ParseRecipe(const std::string& toml, const std::filesystem::path& file,
                   std::optional<std::uint32_t> seed = {});

std::vector<std::string> RecipeNames();                  // sorted
std::string RecipeDescription(const std::string& name);  // one line
// A known name, or else a file. UsageError with the nearest known name where it is neither.
Recipe FindRecipe(const std::string& name_or_file, std::optional<std::uint32_t> seed = {});

// What goes together: a lens with a focus, noise with a full well. UsageError naming `where`.
void Check(const Recipe& recipe, const std::string& where);

// Every value, also those that the recipe left out; reads back to the same capture.
std::string ToToml(const Recipe& recipe);

}  // namespace lamella
