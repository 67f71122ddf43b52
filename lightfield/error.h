// Errors that a user can act on: what, where, what to do, and the program's exit code.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace lamella {

// What the program returns; docs/formats.md lists them for users.
enum class ExitCode : int {
  kDone = 0,
  kUsage = 2,         // the command line or a config file is wrong
  kInput = 3,         // the input can't be used
  kGate = 4,          // a result missed its gate; what there is was written
  kMachine = 5,       // the machine lacks something: program, permission, disk, memory
  kBug = 6,           // our own fault
  kInterrupted = 130  // Ctrl-C
};

class Error : public std::runtime_error {
 public:
  // what() is the one line "where: what; fix" ("where: " is left out where `where` is empty).
  Error(ExitCode code, std::string_view where, std::string_view what, std::string_view fix);
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

// The three that come up everywhere.
Error UsageError(std::string_view where, std::string_view what, std::string_view fix);
Error InputError(std::string_view where, std::string_view what, std::string_view fix);
Error MachineError(std::string_view where, std::string_view what, std::string_view fix);

// The candidate with the smallest edit distance to `name`; empty where there is none.
std::string NearestName(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace lamella
