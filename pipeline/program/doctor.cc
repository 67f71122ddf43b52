// lamella doctor: everything that is needed outside of the program, found or not.
#include <filesystem>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "pipeline/poses/colmap.h"
#include "pipeline/program/command_line.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

void Line(bool good, const std::string& what, const std::string& detail) {
  fmt::print("{:<9} {:<12} {}\n", good ? "found" : "MISSING", what, detail);
}

ExitCode RunDoctor() {
  fmt::print("lamella {}\n", ProgramVersion());
  const std::optional<std::string> colmap = ColmapVersion();
  Line(colmap.has_value(), "COLMAP",
       colmap ? *colmap
              : "poses of photographs need it: apt-get install colmap (a camera grid does not)");
  const double gib = static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                     static_cast<double>(sysconf(_SC_PAGE_SIZE)) / (1 << 30);
  Line(gib >= 2, "memory", fmt::format("{:.1f} GiB (balanced wants 2)", gib));
  Line(true, "processors", fmt::format("{}", std::thread::hardware_concurrency()));
  std::error_code error;
  const auto space = std::filesystem::space(".", error);
  const double free_gib = error ? 0 : static_cast<double>(space.available) / (1 << 30);
  Line(free_gib >= 2, "disk",
       fmt::format("{:.1f} GiB free here (a full-HD two-layer display takes about 1)", free_gib));
  return colmap && gib >= 2 && free_gib >= 2 ? ExitCode::kDone : ExitCode::kMachine;
}

}  // namespace

void AddDoctor(CLI::App& program, Invocation& invocation) {
  CLI::App& app =
      *program.add_subcommand("doctor", "what the program needs of this machine, found or not");
  AddGlobalOptions(app, invocation);
  app.callback([&invocation] { invocation.action = [](Progress&) { return RunDoctor(); }; });
}

}  // namespace lamella
