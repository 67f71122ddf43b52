// lamella synth scene: generated captures with exact truth.
#include "pipeline/synth_scene.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/program/command_line.h"
#include "pipeline/program/synth.h"

namespace lamella {
namespace {

struct SceneArguments {
  std::string name, out;
  std::optional<double> seed;
  bool list = false;
  OptionFlags seed_flag, flags;
};

OptionTable SeedTable(std::optional<double>& seed) {
  return {"cameras",
          {{"seed",
            "of textures, unsteady cameras and all degradation [the recipe's]",
            &seed,
            0,
            1e9,
            {},
            "--seed"}}};
}

std::vector<OptionTable> TablesOf(Recipe& recipe) {
  return {Describe(recipe.layout), Describe(recipe.photographs), Describe(recipe.degradation)};
}

std::string ListOfScenes() {
  std::string list;
  for (const std::string& name : RecipeNames()) {
    list += fmt::format("  {:<17} {}\n", name, RecipeDescription(name));
  }
  return list;
}

std::string Footer() {
  return "Scenes:\n" + ListOfScenes() +
         "\nWrites images/, depth/ (exact, along the optical axis; +inf: background), "
         "transforms.json (exact\n"
         "cameras), recipe.toml (the recipe with every value), degradation.json (what was drawn "
         "at random) and,\n"
         "of views that see background, masks/ (255: a surface, 0: background). In brackets: what "
         "holds where\nthe recipe says nothing.\n\n"
         "Examples: a capture, and the display's images from its photographs alone\n"
         "  lamella synth scene room --out room\n"
         "  lamella run room/images --workspace W --display paper-two-layer\n"
         "a grid of 81 cameras before it, with their poses\n"
         "  lamella synth scene room --out grid --layout grid --views 81\n"
         "  lamella run grid --workspace W --display paper-two-layer\n"
         "a scene of your own (docs/formats.md), through a worse camera\n"
         "  lamella synth scene mine.toml --out mine --degradation-full-well-e 4000";
}

ExitCode Run(const SceneArguments& arguments, Progress& progress) {
  if (arguments.list) {
    fmt::print("{}", ListOfScenes());
    return ExitCode::kDone;
  }
  if (arguments.name.empty() || arguments.out.empty()) {
    throw UsageError("", arguments.name.empty() ? "no scene is given" : "--out is not given",
                     "give the name of a scene or a recipe's TOML file, and --out FOLDER");
  }
  std::optional<double> seed;
  arguments.seed_flag.Apply({SeedTable(seed)});
  std::optional<std::uint32_t> whole;
  if (seed) {
    if (*seed != std::floor(*seed)) {
      throw UsageError("--seed", fmt::format("seed = {} is not a whole number", *seed),
                       "give a whole number");
    }
    whole = static_cast<std::uint32_t>(*seed);
  }
  Recipe recipe = FindRecipe(arguments.name, whole);
  arguments.flags.Apply(TablesOf(recipe));
  const int photographs = SynthScene(std::move(recipe), arguments.out, progress);
  fmt::print("{} photographs in {}/images, truth beside them\n", photographs, arguments.out);
  return ExitCode::kDone;
}

}  // namespace

void AddSynthScene(CLI::App& synth, Invocation& invocation) {
  CLI::App& verb = *synth.add_subcommand(
      "scene", "photographs of a generated scene, with exact poses and depth beside them");
  auto arguments = std::make_shared<SceneArguments>();
  verb.add_option("NAME", arguments->name, "a scene that --list lists, or a recipe's TOML file");
  verb.add_option("--out", arguments->out, "folder to write the capture to");
  verb.add_flag("--list", arguments->list, "the scenes that are known by name, and nothing else");
  Recipe defaults;
  arguments->seed_flag.Add(verb, {SeedTable(arguments->seed)});
  arguments->flags.Add(verb, TablesOf(defaults));
  AddGlobalOptions(verb, invocation);
  verb.footer(Footer);
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) { return Run(*arguments, progress); };
  });
}

}  // namespace lamella
