// lamella status: which stages are done, what they found, what they took.
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/pipeline.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

const char* Word(StageState state) {
  switch (state) {
    case StageState::kMissing:
      return "not run";
    case StageState::kUnfinished:
      return "unfinished";
    case StageState::kStale:
      return "out of date";
    case StageState::kDone:
      return "done";
  }
  return "";
}

void Print(const StageStatus& status) {
  fmt::print("{:<8} {}", status.name, Word(status.state));
  if (status.record && status.record->finished) {
    fmt::print("  {:.1f} s, {:.0f} MiB", status.record->seconds, status.record->peak_memory_mib);
  }
  fmt::print("\n");
  if (!status.record) return;
  const StageReport& report = status.record->report;
  for (const auto& [key, value] : report.summary) fmt::print("         {}: {}\n", key, value);
  for (const std::string& warning : report.warnings) fmt::print("         warning: {}\n", warning);
  if (!report.missed_gate.empty()) fmt::print("         missed: {}\n", report.missed_gate);
}

ExitCode RunStatus(const std::string& folder) {
  const Workspace workspace(folder);
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    throw InputError(folder, "is no workspace", "give the --workspace of an earlier `lamella run`");
  }
  for (const StageStatus& status : StatusOf(workspace)) Print(status);
  return ExitCode::kDone;
}

}  // namespace

void AddStatus(CLI::App& program, Invocation& invocation) {
  CLI::App& app =
      *program.add_subcommand("status", "which stages of a workspace are done, and what they say");
  auto workspace = std::make_shared<std::string>();
  app.add_option("--workspace,-w,WORKSPACE", *workspace, "folder of the results")->required();
  AddGlobalOptions(app, invocation);
  app.callback([workspace, &invocation] {
    invocation.action = [workspace](Progress&) { return RunStatus(*workspace); };
  });
}

}  // namespace lamella
