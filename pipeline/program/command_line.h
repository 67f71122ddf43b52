// What the verbs of `lamella` share: global options, and option tables as command-line flags.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lightfield/error.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"

namespace CLI {
class App;
}

namespace lamella {

// A verb's work, chosen by parsing.
using Action = std::function<ExitCode(Progress&)>;

struct Invocation {
  int threads = 0;  // 0: all
  bool quiet = false, verbose = false;
  std::string progress = "auto";
  Action action;
};

// --threads, --quiet, --verbose, --progress: every verb has them.
void AddGlobalOptions(CLI::App& verb, Invocation& invocation);

// Of --quality; UsageError with the nearest name where there is none of that name.
Quality ParseQuality(const std::string& name);

// The fields of option tables as flags of a verb. What the user gave is kept as text and set by
// Apply, so that it can be put on top of the files' values.
class OptionFlags {
 public:
  // `defaults` must be the options that hold where nothing is given: the help shows them.
  void Add(CLI::App& verb, const std::vector<OptionTable>& defaults);
  void Apply(const std::vector<OptionTable>& tables) const;

 private:
  std::map<std::string, std::string> given_;  // flag -> text; nodes are stable
  std::map<std::string, bool> is_given_;
};

// Each adds its verb to the program.
void AddStageVerbs(CLI::App& program, Invocation& invocation);
void AddStatus(CLI::App& program, Invocation& invocation);
void AddCompare(CLI::App& program, Invocation& invocation);
void AddCompareImages(CLI::App& compare, Invocation& invocation);  // to the verb compare
void AddAnalyze(CLI::App& program, Invocation& invocation);
void AddDisplays(CLI::App& program, Invocation& invocation);
void AddSynth(CLI::App& program, Invocation& invocation);
void AddCalibrate(CLI::App& program, Invocation& invocation);
void AddDoctor(CLI::App& program, Invocation& invocation);
void AddViews(CLI::App& program, Invocation& invocation);
void AddQuilt(CLI::App& program, Invocation& invocation);

}  // namespace lamella
