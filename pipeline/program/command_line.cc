#include "pipeline/program/command_line.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace lamella {

void AddGlobalOptions(CLI::App& verb, Invocation& invocation) {
  const char* group = "Program";
  verb.add_option("--threads", invocation.threads,
                  "threads to use (0: all); never changes a result")
      ->check(CLI::Range(0, 1024))
      ->group(group);
  verb.add_option("--progress", invocation.progress, "auto, bar, plain or json, on standard error")
      ->check(CLI::IsMember({"auto", "bar", "plain", "json"}))
      ->group(group);
  verb.add_flag("--quiet", invocation.quiet, "errors only")->group(group);
  verb.add_flag("--verbose", invocation.verbose, "also what is skipped or chosen, and why")
      ->group(group);
}

Quality ParseQuality(const std::string& name) {
  if (const std::optional<Quality> quality = QualityFromName(name)) return *quality;
  throw UsageError("--quality", fmt::format("there is no quality \"{}\"", name),
                   fmt::format("did you mean \"{}\"? (draft, balanced, best)",
                               NearestName(name, {"draft", "balanced", "best"})));
}

void OptionFlags::Add(CLI::App& verb, const std::vector<OptionTable>& defaults) {
  for (const OptionTable& table : defaults) {
    for (const OptionField& field : table.fields) {
      const std::string flag = FlagOf(table, field);
      if (given_.contains(flag)) continue;  // of an earlier table: it sets both
      std::string help = field.help;
      if (!field.choices.empty()) help += fmt::format(" ({})", fmt::join(field.choices, ", "));
      if (const std::string text = OptionText(field); !text.empty() && text != "\"\"") {
        help += fmt::format(" [{}]", text);
      }
      std::string& text = given_[flag];
      bool& is_given = is_given_[flag];
      verb.add_option_function<std::string>(
              flag,
              [&text, &is_given](const std::string& value) {
                text = value;
                is_given = true;
              },
              help)
          ->type_name("")
          ->group("Options of " + table.section);
    }
  }
}

void OptionFlags::Apply(const std::vector<OptionTable>& tables) const {
  for (const OptionTable& table : tables) {
    for (const OptionField& field : table.fields) {
      const std::string flag = FlagOf(table, field);
      const auto given = is_given_.find(flag);
      if (given != is_given_.end() && given->second) SetOption(field, given_.at(flag), flag);
    }
  }
}

}  // namespace lamella
