// Options: one struct per stage with one description per field. The command line, TOML files and
// the help all come from that description, an OptionTable.
//
//   struct DepthOptions { int labels = 96; ... };
//   OptionTable Describe(DepthOptions& options) {
//     return {"depth", {{"labels", "number of depth hypotheses", &options.labels, 8, 1024}}};
//   }
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace lamella {

using OptionValue = std::variant<bool*, int*, double*, std::string*, std::optional<double>*>;

struct OptionField {
  std::string name;  // TOML key; words joined by '_', units at the end
  std::string help;  // one line, says the unit
  OptionValue value;
  double min = -std::numeric_limits<double>::infinity();  // numbers outside are refused
  double max = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices = {};  // of a string; empty: any
  std::string flag = {};                  // command line; default "--SECTION-NAME" with '-' for '_'
};

struct OptionTable {
  std::string section;  // TOML table
  std::vector<OptionField> fields;
};

std::string FlagOf(const OptionTable& table, const OptionField& field);

// Sets a field from text; UsageError naming `where` (a flag, or FILE:LINE) where it does not fit.
void SetOption(const OptionField& field, std::string_view text, std::string_view where);
std::string OptionText(const OptionField& field);  // as TOML writes it; "" for an unset optional

// Sets what the file names. UsageError with file and line where the TOML is broken, a table or key
// is unknown (the nearest known name is offered), or a value has the wrong type or range.
void ApplyToml(const std::filesystem::path& path, const std::vector<OptionTable>& tables);

// Every option with its value; reads back to the same values.
std::string ToToml(const std::vector<OptionTable>& tables);

enum class Quality { kDraft, kBalanced, kBest };
std::optional<Quality> QualityFromName(std::string_view name);  // draft, balanced, best

}  // namespace lamella
