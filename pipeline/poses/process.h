// Another program, run to its end.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lamella {

struct Command {
  std::filesystem::path program;
  std::vector<std::string> arguments;
  // Set on top of this process's own environment.
  std::vector<std::pair<std::string, std::string>> environment;
};

struct ProcessResult {
  int exit_code = 0;  // -1 where a signal ended it
  int signal = 0;     // 0 where it exited
  bool Succeeded() const { return exit_code == 0 && signal == 0; }
};

// Runs the program with nothing on its standard input and gives every line of its standard output
// and standard error to `on_line`, in order of arrival. The program has a process group of its own
// and dies with this process, whatever ends that; where `on_line` throws, it is killed and the
// exception goes on. To be called from a thread that lives as long as the program.
// MachineError where it can't be started.
ProcessResult RunProcess(const Command& command,
                         const std::function<void(std::string_view line)>& on_line);

// The program of that name in PATH.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

}  // namespace lamella
