#include "pipeline/capture/select_views.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <fnmatch.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr const char* kFlag = "--views";

struct FilePattern {
  std::string text;
  bool leaves_out = false;
};

std::vector<FilePattern> Parse(const std::string& patterns) {
  std::vector<FilePattern> parsed;
  std::istringstream list(patterns);
  for (std::string text; std::getline(list, text, ',');) {
    const bool leaves_out = !text.empty() && text[0] == '!';
    if (leaves_out) text.erase(0, 1);
    if (text.empty()) throw UsageError(kFlag, "has an empty pattern", "give NAME, GLOB or !NAME");
    parsed.push_back({text, leaves_out});
  }
  return parsed;
}

// Names are compared first, so that a name with a bracket or a star means itself.
bool Meets(const std::string& name, const std::string& pattern) {
  return name == pattern || fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

}  // namespace

std::vector<bool> SelectViews(const std::vector<std::string>& names, const std::string& patterns) {
  const std::vector<FilePattern> parsed = Parse(patterns);
  const bool all = std::all_of(parsed.begin(), parsed.end(),
                               [](const FilePattern& pattern) { return pattern.leaves_out; });
  std::vector<bool> chosen(names.size(), all), left_out(names.size(), false);
  for (const FilePattern& pattern : parsed) {
    bool met = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!Meets(names[i], pattern.text)) continue;
      met = true;
      (pattern.leaves_out ? left_out : chosen)[i] = true;
    }
    if (!met) {
      throw UsageError(kFlag, fmt::format("no view is called \"{}\"", pattern.text),
                       fmt::format("did you mean \"{}\"?", NearestName(pattern.text, names)));
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) chosen[i] = chosen[i] && !left_out[i];
  if (std::find(chosen.begin(), chosen.end(), true) == chosen.end()) {
    throw UsageError(kFlag, "leaves no view", "choose at least two");
  }
  return chosen;
}

}  // namespace lamella
