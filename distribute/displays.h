// The displays that the program knows by name; their TOML is built into it.
#pragma once

#include <string>
#include <vector>

#include "lightfield/display.h"

namespace lamella {

std::vector<std::string> DisplayNames();  // sorted

// A known name, or else a file. UsageError with the nearest
// known name where it is neither.
Display FindDisplay(const std::string& name_or_file);

}  // namespace lamella
