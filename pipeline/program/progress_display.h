// What the program shows of its progress, always on standard error.
#pragma once

#include <memory>
#include <string>

#include "lightfield/progress.h"

namespace lamella {

enum class ProgressStyle {
  kAuto,   // a bar on a terminal, plain lines elsewhere
  kBar,    // one line that is drawn again, with rate and time left
  kPlain,  // a line at a task's start and end and every few seconds
  kJson,   // an object a line: task, done, total, unit, seconds; or note, warning
};
enum class Verbosity { kQuiet, kNormal, kVerbose };

std::unique_ptr<Progress> MakeProgress(ProgressStyle style, Verbosity verbosity);

}  // namespace lamella
