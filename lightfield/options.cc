#include "lightfield/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <type_traits>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

std::string Dashed(std::string text) {
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

std::vector<std::string> Names(const std::vector<OptionField>& fields) {
  std::vector<std::string> names;
  for (const OptionField& field : fields) names.push_back(field.name);
  return names;
}

Error Refused(const OptionField& field, std::string_view where, std::string_view text,
              std::string_view expected) {
  return UsageError(where, fmt::format("{} = \"{}\" is not {}", field.name, text, expected),
                    "give " + std::string(expected));
}

double ParseNumber(const OptionField& field, std::string_view text, std::string_view where,
                   bool integer) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number) ||
      (integer && number != std::floor(number))) {
    throw Refused(field, where, text, integer ? "a whole number" : "a finite number");
  }
  if (number < field.min || number > field.max) {
    throw Refused(field, where, text,
                  fmt::format("a number from {:g} to {:g}", field.min, field.max));
  }
  if (integer && std::abs(number) > 2e9) throw Refused(field, where, text, "within 2e9");
  return number;
}

void SetText(const OptionField& field, std::string& value, std::string_view text,
             std::string_view where) {
  const auto& choices = field.choices;
  if (!choices.empty() && std::find(choices.begin(), choices.end(), text) == choices.end()) {
    throw UsageError(where, fmt::format("{} has no value \"{}\"", field.name, text),
                     fmt::format("did you mean \"{}\"? (one of: {})", NearestName(text, choices),
                                 fmt::join(choices, ", ")));
  }
  value = text;
}

std::string NumberText(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

// What SetOption takes for a TOML node of a type that suits the field.
std::string NodeText(const OptionField& field, const toml::node& node, std::string_view where) {
  const bool wants_text = std::holds_alternative<std::string*>(field.value);
  const bool wants_truth = std::holds_alternative<bool*>(field.value);
  if (const auto* text = node.as_string(); text && wants_text) return text->get();
  if (const auto* truth = node.as_boolean(); truth && wants_truth)
    return truth->get() ? "true" : "false";
  if (!wants_text && !wants_truth) {
    if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
    if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  }
  throw UsageError(where, fmt::format("{} has the wrong type", field.name),
                   wants_text    ? "give a string in quotes"
                   : wants_truth ? "give true or false"
                                 : "give a number");
}

void ApplyTable(const std::filesystem::path& path, const toml::table& values,
                const OptionTable& table) {
  for (const auto& [key, node] : values) {
    const std::string where = fmt::format("{}:{}", path.string(), node.source().begin.line);
    const auto field =
        std::find_if(table.fields.begin(), table.fields.end(),
                     [&, k = &key](const OptionField& f) { return f.name == k->str(); });
    if (field == table.fields.end()) {
      throw UsageError(
          where, fmt::format("[{}] has no key \"{}\"", table.section, key.str()),
          fmt::format("did you mean \"{}\"?", NearestName(key.str(), Names(table.fields))));
    }
    SetOption(*field, NodeText(*field, node, where), where);
  }
}

}  // namespace

std::string FlagOf(const OptionTable& table, const OptionField& field) {
  if (!field.flag.empty()) return field.flag;
  return "--" + Dashed(table.section + "-" + field.name);
}

void SetOption(const OptionField& field, std::string_view text, std::string_view where) {
  std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, bool>) {
          if (text != "true" && text != "false") throw Refused(field, where, text, "true or false");
          *value = text == "true";
        } else if constexpr (std::is_same_v<T, std::string>) {
          SetText(field, *value, text, where);
        } else {
          *value = static_cast<std::conditional_t<std::is_same_v<T, int>, int, double>>(
              ParseNumber(field, text, where, std::is_same_v<T, int>));
        }
      },
      field.value);
}

std::string OptionText(const OptionField& field) {
  return std::visit(
      [](const auto* value) -> std::string {
        using T = std::remove_cv_t<std::remove_pointer_t<decltype(value)>>;
        if constexpr (std::is_same_v<T, bool>) {
          return *value ? "true" : "false";
        } else if constexpr (std::is_same_v<T, int>) {
          return fmt::format("{}", *value);
        } else if constexpr (std::is_same_v<T, double>) {
          return NumberText(*value);
        } else if constexpr (std::is_same_v<T, std::string>) {
          return Quoted(*value);
        } else {
          return *value ? NumberText(**value) : std::string();
        }
      },
      field.value);
}

void ApplyToml(const std::filesystem::path& path, const std::vector<OptionTable>& tables) {
  toml::table document;
  try {
    document = toml::parse(ReadText(path), path.string());
  } catch (const toml::parse_error& error) {
    throw UsageError(fmt::format("{}:{}", path.string(), error.source().begin.line),
                     error.description(), "mend the TOML");
  }
  std::vector<std::string> sections;
  for (const OptionTable& table : tables) sections.push_back(table.section);
  for (const auto& [key, node] : document) {
    const std::string where = fmt::format("{}:{}", path.string(), node.source().begin.line);
    const auto table =
        std::find_if(tables.begin(), tables.end(),
                     [&, k = &key](const OptionTable& t) { return t.section == k->str(); });
    if (table == tables.end()) {
      throw UsageError(where, fmt::format("no options are called \"{}\"", key.str()),
                       fmt::format("did you mean [{}]?", NearestName(key.str(), sections)));
    }
    if (!node.is_table()) {
      throw UsageError(where, fmt::format("\"{}\" is not a table", key.str()),
                       fmt::format("write [{}] on a line of its own, then its keys", key.str()));
    }
    ApplyTable(path, *node.as_table(), *table);
  }
}

std::string ToToml(const std::vector<OptionTable>& tables) {
  std::string text;
  for (const OptionTable& table : tables) {
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", table.section);
    for (const OptionField& field : table.fields) {
      const std::string value = OptionText(field);
      const std::string choices =
          field.choices.empty() ? "" : fmt::format(" ({})", fmt::join(field.choices, ", "));
      text += value.empty()
                  ? fmt::format("# {} is not set  # {}{}\n", field.name, field.help, choices)
                  : fmt::format("{} = {}  # {}{}\n", field.name, value, field.help, choices);
    }
  }
  return text;
}

std::optional<Quality> QualityFromName(std::string_view name) {
  if (name == "draft") return Quality::kDraft;
  if (name == "balanced") return Quality::kBalanced;
  if (name == "best") return Quality::kBest;
  return std::nullopt;
}

}  // namespace lamella
