// The part of a recipe that says what there is to see. Heavy: for .cc files only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets_synthetic/scene.h"
#include "lightfield/strict_toml-inl.h"

namespace lamella {

// The recipe's keys that ReadRecipeScene reads.
const std::vector<std::string>& RecipeSceneKeys();

// Files are relative to `folder`.
Scene ReadRecipeScene(const StrictTable& recipe, const std::filesystem::path& folder,
                      std::uint32_t seed);

}  // namespace lamella
