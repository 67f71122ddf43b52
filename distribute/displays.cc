#include "distribute/displays.h"

#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "distribute/displays_embedded.h"
#include "lightfield/error.h"

namespace lamella {

std::vector<std::string> DisplayNames() {
  std::vector<std::string> names;
  for (const EmbeddedDisplay& display : EmbeddedDisplays()) names.emplace_back(display.name);
  return names;
}

Display FindDisplay(const std::string& name_or_file) {
  for (const EmbeddedDisplay& display : EmbeddedDisplays()) {
    if (display.name == name_or_file) return ParseDisplay(std::string(display.toml), name_or_file);
  }
  const std::filesystem::path path(name_or_file);
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(path, error);
  if (is_file) return ReadDisplay(path);
  if (path.extension() == ".toml" || path.has_parent_path()) {
    throw UsageError("--display", fmt::format("there is no file \"{}\"", name_or_file),
                     "give a display's TOML file, or one of " +
                         fmt::format("{}", fmt::join(DisplayNames(), ", ")));
  }
  throw UsageError(
      "--display", fmt::format("no display is called \"{}\"", name_or_file),
      fmt::format("did you mean \"{}\"? (one of {}, or a TOML file)",
                  NearestName(name_or_file, DisplayNames()), fmt::join(DisplayNames(), ", ")));
}

}  // namespace lamella
