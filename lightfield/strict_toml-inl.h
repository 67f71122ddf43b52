// A TOML table read strictly: unknown keys, wrong types and numbers out of range are refused with
// file and line. Heavy: for .cc files only.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>
#include <toml++/toml.h>

#include "lightfield/error.h"
#include "lightfield/options.h"

namespace lamella {

// UsageError with file and line where the text is no TOML.
inline toml::table ParseStrictToml(const std::string& text, const std::string& file) {
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw UsageError(fmt::format("{}:{}", file, error.source().begin.line), error.description(),
                     "mend the TOML");
  }
}

// All values are optional where they are read; Need says which ones are not. The document must
// outlive the table.
class StrictTable {
 public:
  // `name` is how messages call the table ("[cameras]", "surface 3").
  StrictTable(const toml::table& table, std::string file, std::string name,
              const std::vector<std::string>& known)
      : table_(table), file_(std::move(file)), name_(std::move(name)) {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      throw UsageError(At(node), fmt::format("{} has no key \"{}\"", name_, key.str()),
                       fmt::format("did you mean \"{}\"?", NearestName(key.str(), known)));
    }
  }

  const std::string& file() const { return file_; }
  const std::string& name() const { return name_; }
  bool Has(std::string_view key) const { return table_.get(key) != nullptr; }
  // FILE:LINE of a key, or of the table where it has no such key.
  std::string Where(std::string_view key = {}) const {
    const toml::node* node = table_.get(key);
    return node ? At(*node) : At(table_);
  }
  Error Wrong(std::string_view key, std::string_view what, std::string_view fix) const {
    return UsageError(Where(key), what, fix);
  }

  std::optional<double> Number(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    return Finite(*node, key, "a number");
  }
  // Above 0.
  std::optional<double> Length(const char* key) const {
    const std::optional<double> length = Number(key);
    if (length && !(*length > 0)) {
      throw Wrong(key, fmt::format("{} = {} is not above 0", key, *length),
                  "give a number above 0");
    }
    return length;
  }
  // From `min` to `max`.
  std::optional<double> Within(const char* key, double min, double max) const {
    const std::optional<double> number = Number(key);
    if (number && !(*number >= min && *number <= max)) {
      throw Wrong(key, fmt::format("{} = {} is out of range", key, *number),
                  fmt::format("give a number from {:g} to {:g}", min, max));
    }
    return number;
  }
  std::optional<int> Whole(const char* key, int min, int max) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    const auto* whole = node->as_integer();
    if (!whole) throw WrongType(*node, key, "a whole number");
    if (whole->get() < min || whole->get() > max) {
      throw Wrong(key, fmt::format("{} = {} is out of range", key, whole->get()),
                  fmt::format("give a whole number from {} to {}", min, max));
    }
    return static_cast<int>(whole->get());
  }
  std::optional<bool> Truth(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (const auto* truth = node->as_boolean()) return truth->get();
    throw WrongType(*node, key, "true or false");
  }
  std::optional<std::string> Text(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (const auto* text = node->as_string()) return text->get();
    throw WrongType(*node, key, "a string in quotes");
  }
  std::optional<std::string> OneOf(const char* key, const std::vector<std::string>& names) const {
    std::optional<std::string> text = Text(key);
    if (text && std::find(names.begin(), names.end(), *text) == names.end()) {
      throw Wrong(key, fmt::format("there is no {} \"{}\"", key, *text),
                  fmt::format("did you mean \"{}\"? (one of: {})", NearestName(*text, names),
                              fmt::join(names, ", ")));
    }
    return text;
  }
  std::optional<Eigen::Vector3d> Vector(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    const toml::array* array = node->as_array();
    if (!array || array->size() != 3) throw WrongType(*node, key, "three numbers [x, y, z]");
    Eigen::Vector3d vector;
    for (int i = 0; i < 3; ++i) {
      vector[i] = Finite(*array->get(static_cast<std::size_t>(i)), key, "three numbers [x, y, z]");
    }
    return vector;
  }
  const toml::table* Table(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return nullptr;
    if (!node->is_table()) throw WrongType(*node, key, fmt::format("a table [{}]", key));
    return node->as_table();
  }
  const toml::array* Tables(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return nullptr;
    if (!node->is_array_of_tables()) throw WrongType(*node, key, fmt::format("tables [[{}]]", key));
    return node->as_array();
  }
  template <class T>
  T Need(const std::optional<T>& value, const char* key) const {
    if (value) return *value;
    throw UsageError(At(table_), fmt::format("{} has no \"{}\"", name_, key),
                     fmt::format("add {} = ... to it", key));
  }

  // Sets the fields that the table has.
  void Apply(const OptionTable& options) const {
    for (const OptionField& field : options.fields) {
      const toml::node* node = table_.get(field.name);
      if (node) SetOption(field, TextOf(field, *node), At(*node));
    }
  }

 private:
  std::string At(const toml::node& node) const {
    return fmt::format("{}:{}", file_, std::max<unsigned>(node.source().begin.line, 1));
  }
  Error WrongType(const toml::node& node, std::string_view key, std::string_view expected) const {
    return UsageError(At(node), fmt::format("{} has the wrong type", key),
                      fmt::format("give {}", expected));
  }
  double Finite(const toml::node& node, std::string_view key, std::string_view expected) const {
    if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
    const auto* real = node.as_floating_point();
    if (!real) throw WrongType(node, key, expected);
    if (!std::isfinite(real->get())) {
      throw UsageError(At(node), fmt::format("{} is {}", key, real->get()), "give a finite number");
    }
    return real->get();
  }
  std::string TextOf(const OptionField& field, const toml::node& node) const {
    const bool wants_text = std::holds_alternative<std::string*>(field.value);
    const bool wants_truth = std::holds_alternative<bool*>(field.value);
    if (const auto* text = node.as_string(); text && wants_text) return text->get();
    if (const auto* truth = node.as_boolean(); truth && wants_truth)
      return truth->get() ? "true" : "false";
    if (!wants_text && !wants_truth) {
      if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
      if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
    }
    throw WrongType(node, field.name,
                    wants_text    ? "a string in quotes"
                    : wants_truth ? "true or false"
                                  : "a number");
  }

  const toml::table& table_;
  std::string file_, name_;
};

}  // namespace lamella
