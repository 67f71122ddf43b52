// lamella displays: list the presets, show one as TOML, check a user's file.
#include "distribute/displays.h"

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "lightfield/display.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

std::string Describe(const Display& display) {
  std::string layers;
  for (const Layer& layer : display.layers) {
    layers += fmt::format("{}{:g}", layers.empty() ? "" : ", ", layer.position_mm);
  }
  return fmt::format("{} x {} px of {:.4f} mm, {} layer{} at {} mm", display.width_px,
                     display.height_px, display.pitch_mm, display.layers.size(),
                     display.layers.size() == 1 ? "" : "s", layers);
}

ExitCode List() {
  for (const std::string& name : DisplayNames()) {
    fmt::print("{:<24} {}\n", name, Describe(FindDisplay(name)));
  }
  return ExitCode::kDone;
}

}  // namespace

void AddDisplays(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "displays", "the displays that the program knows, and checks of your own");
  app.require_subcommand(0, 1);
  // Alone it lists; a subcommand's callback comes later and takes its place.
  app.parse_complete_callback(
      [&invocation] { invocation.action = [](Progress&) { return List(); }; });
  app.add_subcommand("list", "names and sizes of the presets (also without a subcommand)");
  auto name = std::make_shared<std::string>();
  CLI::App& show =
      *app.add_subcommand("show", "a display as TOML: the start of a file of your own");
  show.add_option("DISPLAY", *name, "preset or file")->required();
  show.callback([name, &invocation] {
    invocation.action = [name](Progress&) {
      fmt::print("{}", ToToml(FindDisplay(*name)));
      return ExitCode::kDone;
    };
  });
  CLI::App& check = *app.add_subcommand("check", "is a display file right? one line tells");
  check.add_option("FILE", *name, "display file (TOML)")->required();
  check.callback([name, &invocation] {
    invocation.action = [name](Progress&) {
      fmt::print("{}: good: {}\n", *name, Describe(FindDisplay(*name)));
      return ExitCode::kDone;
    };
  });
}

}  // namespace lamella
