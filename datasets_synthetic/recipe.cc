#include "datasets_synthetic/recipe.h"

#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets_synthetic/recipe_scene-inl.h"
#include "datasets_synthetic/recipes_embedded.h"
#include "lightfield/atomic_file.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr int kFormatVersion = 1;

std::vector<std::string> NamesOf(const OptionTable& options) {
  std::vector<std::string> names;
  for (const OptionField& field : options.fields) names.push_back(field.name);
  return names;
}

// Sets what a table of the recipe names; `more` are keys that the caller reads.
StrictTable ReadOptions(const StrictTable& top, const OptionTable& options,
                        std::vector<std::string> more, const toml::table& nothing) {
  const toml::table* node = top.Table(options.section.c_str());
  const std::vector<std::string> names = NamesOf(options);
  more.insert(more.end(), names.begin(), names.end());
  StrictTable table(node ? *node : nothing, top.file(), "[" + options.section + "]", more);
  table.Apply(options);
  return table;
}

// A copy of a texture's or a surface's table with its file's absolute path.
void MakeAbsolute(toml::table& table, const fs::path& folder) {
  if (toml::value<std::string>* file = table["file"].as_string()) {
    file->get() = fs::absolute(folder / file->get()).lexically_normal().string();
  }
  if (toml::table* texture = table["texture"].as_table()) MakeAbsolute(*texture, folder);
}

// The scene's tables as they were, files by their absolute paths.
std::string SceneToml(const toml::table& document, const fs::path& folder) {
  toml::table scene;
  for (const std::string& key : RecipeSceneKeys()) {
    if (const toml::node* node = document.get(key)) {
      node->visit([&](const auto& value) { scene.insert_or_assign(key, value); });
    }
  }
  for (const char* key : {"texture", "surface"}) {
    if (toml::array* tables = scene[key].as_array()) {
      for (toml::node& node : *tables) MakeAbsolute(*node.as_table(), folder);
    }
  }
  std::ostringstream text;
  text << scene;
  return text.str();
}

std::string Quoted(const std::string& text) {
  std::ostringstream quoted;
  quoted << toml::value<std::string>(text);
  return quoted.str();
}

}  // namespace

OptionTable Describe(PhotographOptions& options) {
  const double inf = std::numeric_limits<double>::infinity();
  return {"photographs",
          {{"supersampling",
            "rays per pixel and axis where surfaces meet",
            &options.supersampling,
            1,
            32,
            {},
            "--supersampling"},
           {"format",
            "of the photographs; exr is float and linear",
            &options.format,
            -inf,
            inf,
            {"jpg", "png", "exr"},
            "--format"}}};
}

void Check(const Recipe& recipe, const std::string& where) {
  const Degradation& d = recipe.degradation;
  if (d.read_noise_e > 0 && d.full_well_e == 0) {
    throw UsageError(where, "read_noise_e has no full_well_e to be measured by",
                     "give full_well_e, the electrons of a white pixel");
  }
  const std::vector<View> views = CamerasOf(recipe.layout, recipe.seed, where);
  Distorted(views.front().camera, d, where);
  ExposuresOf(d, static_cast<int>(views.size()), recipe.seed, recipe.layout.distance, where);
}

Recipe ParseRecipe(const std::string& toml, const fs::path& file,
                   std::optional<std::uint32_t> seed) {
  const toml::table document = ParseStrictToml(toml, file.string()), nothing;
  std::vector<std::string> keys = {"format_version", "name",        "description", "seed",
                                   "cameras",        "degradation", "photographs"};
  keys.insert(keys.end(), RecipeSceneKeys().begin(), RecipeSceneKeys().end());
  const StrictTable top(document, file.string(), "the recipe", keys);
  const int version = top.Whole("format_version", 1, 1000000).value_or(kFormatVersion);
  if (version > kFormatVersion) {
    throw top.Wrong("format_version", fmt::format("format_version = {} is not known here", version),
                    fmt::format("this program reads version {}", kFormatVersion));
  }
  Recipe recipe;
  recipe.name = top.Text("name").value_or(file.stem().string());
  recipe.description = top.Text("description").value_or("");
  const int own_seed = top.Whole("seed", 0, 1000000000).value_or(1);
  recipe.seed = seed.value_or(static_cast<std::uint32_t>(own_seed));
  const StrictTable cameras = ReadOptions(top, Describe(recipe.layout), {"target"}, nothing);
  recipe.layout.target = cameras.Vector("target").value_or(recipe.layout.target);
  const StrictTable degradation = ReadOptions(top, Describe(recipe.degradation), {}, nothing);
  ReadOptions(top, Describe(recipe.photographs), {}, nothing);
  Check(recipe, top.Has("degradation") ? degradation.Where() : cameras.Where());
  const fs::path folder = file.parent_path();
  recipe.scene = ReadRecipeScene(top, folder, recipe.seed);
  recipe.scene_toml = SceneToml(document, folder);
  return recipe;
}

Recipe ReadRecipe(const fs::path& path, std::optional<std::uint32_t> seed) {
  return ParseRecipe(ReadText(path), path, seed);
}

std::vector<std::string> RecipeNames() {
  std::vector<std::string> names;
  for (const EmbeddedRecipe& recipe : EmbeddedRecipes()) names.emplace_back(recipe.name);
  return names;
}

std::string RecipeDescription(const std::string& name) {
  for (const EmbeddedRecipe& recipe : EmbeddedRecipes()) {
    if (recipe.name != name) continue;
    const toml::table document = ParseStrictToml(std::string(recipe.toml), name);
    return document["description"].value_or(std::string());
  }
  return {};
}

Recipe FindRecipe(const std::string& name_or_file, std::optional<std::uint32_t> seed) {
  for (const EmbeddedRecipe& recipe : EmbeddedRecipes()) {
    if (recipe.name != name_or_file) continue;
    return ParseRecipe(std::string(recipe.toml), name_or_file + ".toml", seed);
  }
  const fs::path path(name_or_file);
  std::error_code error;
  if (fs::is_regular_file(path, error)) return ReadRecipe(path, seed);
  const std::string names = fmt::format("{}", fmt::join(RecipeNames(), ", "));
  if (path.extension() == ".toml" || path.has_parent_path()) {
    throw UsageError("", fmt::format("there is no file \"{}\"", name_or_file),
                     "give a recipe's TOML file, or one of " + names);
  }
  throw UsageError("", fmt::format("there is no scene \"{}\"", name_or_file),
                   fmt::format("did you mean \"{}\"? (one of {}, or a recipe's TOML file)",
                               NearestName(name_or_file, RecipeNames()), names));
}

std::string ToToml(const Recipe& recipe) {
  Recipe copy;
  copy.layout = recipe.layout;
  copy.degradation = recipe.degradation;
  copy.photographs = recipe.photographs;
  const Eigen::Vector3d& target = recipe.layout.target;
  // builtin, a key of no table, must stand before the first one: scene_toml begins with it.
  return fmt::format(
      "format_version = {}\nname = {}\ndescription = {}\nseed = {}\n{}\n\n{}"
      "target = [{}, {}, {}]  # what the cameras look at, world units\n\n{}",
      kFormatVersion, Quoted(recipe.name), Quoted(recipe.description), recipe.seed,
      recipe.scene_toml, ToToml(std::vector<OptionTable>{Describe(copy.layout)}), target.x(),
      target.y(), target.z(),
      ToToml(std::vector<OptionTable>{Describe(copy.degradation), Describe(copy.photographs)}));
}

}  // namespace lamella
