#include "lightfield/error.h"

#include <algorithm>
#include <numeric>

namespace lamella {
namespace {

std::string OneLine(std::string_view where, std::string_view what, std::string_view fix) {
  std::string line;
  if (!where.empty()) line.append(where).append(": ");
  line.append(what);
  if (!fix.empty()) line.append("; ").append(fix);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

// Levenshtein distance, one row at a time.
int EditDistance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

Error::Error(ExitCode code, std::string_view where, std::string_view what, std::string_view fix)
    : std::runtime_error(OneLine(where, what, fix)), code_(code) {}

Error UsageError(std::string_view where, std::string_view what, std::string_view fix) {
  return {ExitCode::kUsage, where, what, fix};
}
Error InputError(std::string_view where, std::string_view what, std::string_view fix) {
  return {ExitCode::kInput, where, what, fix};
}
Error MachineError(std::string_view where, std::string_view what, std::string_view fix) {
  return {ExitCode::kMachine, where, what, fix};
}

std::string NearestName(std::string_view name, const std::vector<std::string>& candidates) {
  const auto nearest = std::min_element(candidates.begin(), candidates.end(),
                                        [&](const std::string& a, const std::string& b) {
                                          return EditDistance(name, a) < EditDistance(name, b);
                                        });
  return nearest == candidates.end() ? std::string() : *nearest;
}

}  // namespace lamella
