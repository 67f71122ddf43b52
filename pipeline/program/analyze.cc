// lamella analyze: what a display can show, and how much of a capture.
#include "distribute/analyze.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "pipeline/analysis_figure.h"
#include "pipeline/analysis_record.h"
#include "pipeline/analysis_table.h"
#include "pipeline/program/command_line.h"
#include "pipeline/stages.h"

namespace lamella {
namespace {

struct AnalyzeArguments {
  std::string display, scene, out;
  bool json = false;
};

ExitCode RunAnalyze(const AnalyzeArguments& arguments, Progress& progress) {
  const Display display = FindDisplay(arguments.display);
  const DepthInterval depths = arguments.scene.empty()
                                   ? DepthsWorthALook(display)
                                   : DepthsFor(display, SceneDepths(Workspace(arguments.scene)));
  const Analysis analysis = Analyze(
      display, depths, display.varifocal ? std::optional(FramesOptions().strokes) : std::nullopt);
  std::optional<SceneAnalysis> scene;
  if (!arguments.scene.empty()) {
    scene = AnalyzeWorkspace(Workspace(arguments.scene), display, analysis);
    if (scene->viewing_distance_mm != display.viewing_distance_mm) {
      progress.Warn(fmt::format("the scene was placed for eyes at {:g} mm, the display is for {:g}",
                                scene->viewing_distance_mm, display.viewing_distance_mm));
    }
  }
  const std::string json = AnalysisJson(display, analysis, scene);
  fmt::print("{}", arguments.json ? json : AnalysisTable(display, analysis, scene));
  if (!arguments.out.empty()) {
    const std::filesystem::path folder(arguments.out);
    CreateFolder(folder);
    WriteTextAtomically(folder / "analysis.json", json);
    WriteTextAtomically(folder / "cutoff.svg", AnalysisFigure(display, analysis, scene));
  }
  return ExitCode::kDone;
}

}  // namespace

void AddAnalyze(CLI::App& program, Invocation& invocation) {
  CLI::App& verb = *program.add_subcommand(
      "analyze", "what a display can show: cut-off and MTF over depth, rays, angles, light");
  auto arguments = std::make_shared<AnalyzeArguments>();
  verb.add_option("DISPLAY", arguments->display, "preset or file (`lamella displays`)")->required();
  verb.add_option(
      "--scene", arguments->scene,
      "a workspace whose layers are made: its depths, and what the display keeps of it");
  verb.add_flag("--json", arguments->json, "print JSON instead of a table");
  verb.add_option("--out", arguments->out, "folder for analysis.json and cutoff.svg");
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Examples:\n"
      "  lamella analyze paper-two-layer\n"
      "  lamella analyze mine.toml --scene W --out figures");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      return RunAnalyze(*arguments, progress);
    };
  });
}

}  // namespace lamella
