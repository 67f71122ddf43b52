// lamella synth layers: a scene's rays to a display's layers (Algorithm 2 of Ranieri et al. 2012).
#include "pipeline/synth_layers.h"

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/program/synth.h"

namespace lamella {
namespace {

struct LayersArguments {
  SynthLayersOptions options;
  std::string workspace, quality;
  OptionFlags flags;
};

ExitCode RunSynthLayers(LayersArguments& arguments, Progress& progress) {
  if (!arguments.quality.empty()) {
    ApplyQuality(ParseQuality(arguments.quality), arguments.options.layers);
  }
  arguments.flags.Apply(Describe(arguments.options));
  const Workspace workspace(arguments.workspace);
  const StageReport report = SynthLayers(arguments.options, workspace, progress);
  for (const auto& [what, value] : report.summary) fmt::print("{:<18} {}\n", what, value);
  fmt::print("{}\n", workspace.Stage("layers").string());
  return ExitCode::kDone;
}

}  // namespace

void AddSynthLayers(CLI::App& synth, Invocation& invocation) {
  CLI::App& verb = *synth.add_subcommand(
      "layers", "a generated scene's rays to the layers of a display (the paper's Algorithm 2)");
  auto arguments = std::make_shared<LayersArguments>();
  verb.add_option("SCENE", arguments->options.scene, "a scene's name or a recipe (TOML)")
      ->required();
  verb.add_option("--workspace,-w", arguments->workspace, "folder of the results: W/layers")
      ->required();
  verb.add_option("--quality", arguments->quality,
                  "set of options: draft, balanced or best; finer options go on top");
  arguments->flags.Add(verb, Describe(arguments->options));
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Examples:\n"
      "  lamella synth layers room --workspace T --display paper-two-layer\n"
      "  lamella frames --workspace T                          the panels' images\n"
      "  lamella synth layers room --workspace T --like W      placed as a capture's W/layers is\n"
      "  lamella compare layers W T                            and how far the two are apart");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      return RunSynthLayers(*arguments, progress);
    };
  });
}

}  // namespace lamella
