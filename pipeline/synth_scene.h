// A generated capture: photographs of a recipe's scene, with exact truth beside them.
#pragma once

#include <filesystem>

#include "datasets_synthetic/recipe.h"
#include "lightfield/progress.h"

namespace lamella {

// Writes into `out`, each file atomically:
//   images/NAME.jpg    the photographs (or .png, .exr), without EXIF
//   depth/NAME.exr     channel Z: depth along the optical axis, exact; +inf where nothing is seen
//   masks/NAME.png     255 where a surface is seen, 0 elsewhere; only of views that see background
//   transforms.json    exact cameras and poses (nerfstudio form); row and column in a grid
//   recipe.toml        the recipe with every value, to make the same capture again
//   degradation.json   what was drawn at random for each photograph (docs/formats.md)
// A file's bytes depend on the recipe alone (recipe.toml names meshes and pictures by whole paths).
// Photographs of an earlier call that this one does not make are removed. Returns the number of
// photographs. UsageError as Check(Recipe).
int SynthScene(Recipe recipe, const std::filesystem::path& out, Progress& progress);

}  // namespace lamella
