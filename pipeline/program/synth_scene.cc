// lamella synth scene: generated captures with exact truth.
#include "pipeline/synth_scene.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/program/command_line.h"
#include "pipeline/program/synth.h"

namespace lamella {
namespace {

struct SceneArguments {
  SynthSceneOptions options;
  std::string out;
  OptionFlags flags;
};

}  // namespace

void AddSynthScene(CLI::App& synth, Invocation& invocation) {
  CLI::App& verb = *synth.add_subcommand(
      "scene", "photographs of a generated scene, with exact poses and depth beside them");
  auto arguments = std::make_shared<SceneArguments>();
  verb.add_option("NAME", arguments->options.name, "room: things at many depths before two walls")
      ->required();
  verb.add_option("--out", arguments->out, "folder to write images/, depth/, transforms.json to")
      ->required();
  arguments->flags.Add(verb, {Describe(arguments->options)});
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Example: a capture, and the display's images from its photographs alone\n"
      "  lamella synth scene room --out room\n"
      "  lamella run room/images --workspace W --display paper-two-layer");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      arguments->flags.Apply({Describe(arguments->options)});
      SynthScene(arguments->options, arguments->out, progress);
      fmt::print("{} photographs in {}/images, truth beside them\n", arguments->options.views,
                 arguments->out);
      return ExitCode::kDone;
    };
  });
}

}  // namespace lamella
