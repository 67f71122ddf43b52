// The program: parses the command line, runs one verb, and turns errors into one line and an exit
// code.
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <glog/logging.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/program/command_line.h"
#include "pipeline/program/interrupt.h"
#include "pipeline/program/progress_display.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

constexpr const char* kFooter =
    "Exit codes: 0 done; 2 the command line or a config file is wrong; 3 the input can't be used; "
    "4 a\n"
    "result missed its gate (what there is was written); 5 the machine lacks something; 6 a bug; "
    "130 interrupted.\n"
    "`lamella VERB --help` tells more. A first try:\n"
    "  lamella run PHOTOS --workspace W --display paper-two-layer";

std::unique_ptr<Progress> ProgressOf(const Invocation& invocation) {
  const ProgressStyle style = invocation.progress == "bar"     ? ProgressStyle::kBar
                              : invocation.progress == "plain" ? ProgressStyle::kPlain
                              : invocation.progress == "json"  ? ProgressStyle::kJson
                                                               : ProgressStyle::kAuto;
  return MakeProgress(style, invocation.quiet     ? Verbosity::kQuiet
                             : invocation.verbose ? Verbosity::kVerbose
                                                  : Verbosity::kNormal);
}

// "lamella displays list".
std::string FullName(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name()
                                     : FullName(*app.get_parent()) + " " + app.get_name();
}

// The verb that the command line chose, or the program itself.
const CLI::App& Deepest(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : Deepest(*chosen.front());
}

std::vector<std::string> KnownNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(verb->get_name());
  }
  return names;
}

int ReportParseError(const CLI::App& program, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
  const CLI::App& verb = Deepest(program);
  std::string line = error.what();
  std::replace(line.begin(), line.end(), '\n', ' ');
  if (const std::vector<std::string> unknown = verb.remaining(); !unknown.empty()) {
    const std::string word = unknown.front().substr(0, unknown.front().find('='));
    line = fmt::format("`{}` does not know \"{}\"; did you mean \"{}\"?", FullName(verb), word,
                       NearestName(word, KnownNames(verb)));
  }
  fmt::print(stderr, "lamella: {} (see `{} --help`)\n", line, FullName(verb));
  return static_cast<int>(ExitCode::kUsage);
}

// Ceres tells of difficulties through glog, which writes to standard error and into files unless it
// is told otherwise. What matters of a solution stands in its report.
void SilenceSolverLog(bool verbose) {
  google::InitGoogleLogging("lamella");
  for (const auto severity : {google::GLOG_INFO, google::GLOG_WARNING, google::GLOG_ERROR}) {
    google::SetLogDestination(severity, "");
  }
  FLAGS_stderrthreshold = verbose ? google::GLOG_WARNING : google::GLOG_FATAL;
}

ExitCode RunGuarded(const Invocation& invocation) {
  const std::unique_ptr<Progress> progress = ProgressOf(invocation);
  const ThreadLimit limit(invocation.threads);
  SilenceSolverLog(invocation.verbose);
  return invocation.action(*progress);
}

int Main(int argc, char** argv) {
  CLI::App program(
      "lamella turns multi-view captures into what a multi-layered automultiscopic display shows.",
      "lamella");
  program.set_version_flag("--version", std::string("lamella ") + ProgramVersion());
  program.require_subcommand(1);
  program.footer(kFooter);
  program.get_formatter()->column_width(36);
  Invocation invocation;
  AddStageVerbs(program, invocation);
  AddStatus(program, invocation);
  AddCompare(program, invocation);
  AddDisplays(program, invocation);
  AddAnalyze(program, invocation);
  AddViews(program, invocation);
  AddQuilt(program, invocation);
  AddSynth(program, invocation);
  AddCalibrate(program, invocation);
  AddDoctor(program, invocation);
  if (argc == 1) {
    fmt::print("{}", program.help());
    return static_cast<int>(ExitCode::kUsage);
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return ReportParseError(program, error);
  }
  try {
    return static_cast<int>(RunGuarded(invocation));
  } catch (const Error& error) {
    fmt::print(stderr, "lamella: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "lamella: not enough memory; use a lower --quality or fewer --views\n");
    return static_cast<int>(ExitCode::kMachine);
  }
}

// Throws nothing, unlike fmt::print.
int ReportBug(const char* what) {
  std::fprintf(stderr, "lamella: a bug: %s; please report it with the command that you typed\n",
               what);
  return static_cast<int>(ExitCode::kBug);
}

}  // namespace
}  // namespace lamella

int main(int argc, char** argv) {
  try {
    lamella::EndAtOnceOnInterrupt();
    return lamella::Main(argc, argv);
  } catch (const std::exception& error) {
    return lamella::ReportBug(error.what());
  } catch (...) {
    return lamella::ReportBug("something was thrown that is no exception");
  }
}
