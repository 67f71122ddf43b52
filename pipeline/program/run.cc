// lamella run, and one verb per stage.
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/pipeline.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string first, last;  // stages
  std::string input, workspace, config, quality;
  OptionFlags flags;
};

const char* What(const std::string& stage) {
  if (stage == "capture") return "list a capture's views and check that every image opens whole";
  if (stage == "poses") return "find the cameras (COLMAP), or take known ones; undistort";
  if (stage == "depth") return "estimate depth and confidence for every view";
  if (stage == "layers")
    return "distribute the scene's rays to the display's layers and prefilter them";
  if (stage == "frames") return "write the images that the panels show";
  return "simulate what eyes see and write preview/index.html";
}

// Defaults < workspace < quality < config < command line.
PipelineOptions Effective(const Arguments& arguments, const Workspace& workspace) {
  PipelineOptions options = OptionsOf(workspace);
  if (!arguments.quality.empty()) ApplyQuality(ParseQuality(arguments.quality), options);
  if (!arguments.config.empty()) ApplyToml(arguments.config, Describe(options));
  arguments.flags.Apply(Describe(options));
  if (!arguments.input.empty()) {
    options.capture.input = fs::absolute(arguments.input).lexically_normal().string();
  }
  for (std::string* file : {&options.capture.cameras, &options.layers.calibration}) {
    if (!file->empty()) *file = fs::absolute(*file).lexically_normal().string();
  }
  return options;
}

// Tables that a stage's results depend on.
std::vector<OptionTable> TablesOf(const std::string& verb, PipelineOptions& o) {
  if (verb == "capture") return {Describe(o.capture)};
  if (verb == "poses") return {Describe(o.poses)};
  if (verb == "depth") return {Describe(o.depth)};
  if (verb == "layers") return {Describe(o.layers), Describe(o.render)};
  if (verb == "frames") return {Describe(o.frames)};
  if (verb == "preview") return {Describe(o.preview), Describe(o.render)};
  return Describe(o);
}

// `input` is the positional, not a flag.
std::vector<OptionTable> FlagTables(const std::string& verb, PipelineOptions& options) {
  std::vector<OptionTable> tables = TablesOf(verb, options);
  for (OptionTable& table : tables) {
    std::erase_if(table.fields, [&](const OptionField& f) {
      return table.section == "capture" && f.name == "input";
    });
  }
  return tables;
}

// A small part of what the layers may take, where a stage follows that reads photographs.
std::size_t KeptPhotographBytes(const PipelineOptions& options, const std::string& last) {
  if (last == "capture" || last == "poses") return 0;
  const double gib = last == "preview" ? options.preview.memory_gib : options.layers.memory_gib;
  return static_cast<std::size_t>(std::ldexp(gib, 30) / 8);
}

ExitCode RunVerb(const Arguments& arguments, Progress& progress) {
  const PipelineOptions options = Effective(arguments, Workspace(arguments.workspace));
  const Workspace workspace(arguments.workspace, KeptPhotographBytes(options, arguments.last));
  const ExitCode code = RunPipeline(workspace, options, arguments.first, arguments.last, progress);
  if (arguments.last == "preview") {
    fmt::print("{}\n", (workspace.Stage("preview") / "index.html").string());
  } else {
    fmt::print("{}\n", workspace.Stage(arguments.last).string());
  }
  return code;
}

void AddVerb(CLI::App& program, Invocation& invocation, const std::string& verb,
             const std::string& help) {
  CLI::App& app = *program.add_subcommand(verb, help);
  auto arguments = std::make_shared<Arguments>();
  arguments->first = verb == "run" ? "capture" : verb;
  arguments->last = verb == "run" ? "preview" : verb;
  if (arguments->first == "capture") {
    app.add_option(
        "INPUT", arguments->input,
        "folder of photographs, of a camera grid (parameters.cfg), or a transforms.json; "
        "may be left out where the workspace has one");
  }
  app.add_option("--workspace,-w", arguments->workspace, "folder of the results")->required();
  app.add_option("--config", arguments->config,
                 "TOML file of options, as lamella.toml in a workspace");
  app.add_option("--quality", arguments->quality,
                 "set of options: draft, balanced (the defaults) or best; finer options go on top");
  if (verb == "run")
    app.add_option("--until", arguments->last, "last stage to run")->capture_default_str();
  PipelineOptions defaults;
  arguments->flags.Add(app, FlagTables(verb, defaults));
  AddGlobalOptions(app, invocation);
  app.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) { return RunVerb(*arguments, progress); };
  });
}

}  // namespace

void AddStageVerbs(CLI::App& program, Invocation& invocation) {
  AddVerb(program, invocation, "run", "all stages in order, those that are not up to date");
  for (const std::string& stage : StageNames()) AddVerb(program, invocation, stage, What(stage));
}

}  // namespace lamella
