#include "pipeline/json_file.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using Value = nlohmann::json;

Value Parse(const std::filesystem::path& path) {
  try {
    Value value = Value::parse(ReadText(path));
    if (!value.is_object())
      throw InputError(path.string(), "is no JSON object", "give another file");
    return value;
  } catch (const Value::exception& error) {
    throw InputError(path.string(), fmt::format("is no JSON ({})", error.what()), "mend the file");
  }
}

void Flatten(const Value& value, std::vector<double>& numbers, bool& good) {
  if (value.is_array()) {
    for (const Value& element : value) Flatten(element, numbers, good);
  } else if (value.is_number() && std::isfinite(value.get<double>())) {
    numbers.push_back(value.get<double>());
  } else {
    good = false;
  }
}

}  // namespace

struct JsonObject::Node {
  std::shared_ptr<const Value> document;
  const Value& value;

  const Value& At(const JsonObject& object, const std::string& key,
                  std::string_view expected) const {
    if (!value.contains(key)) throw object.Wrong(key, expected);
    return value.at(key);
  }
  std::shared_ptr<const Node> Child(const Value& child) const {
    return std::make_shared<Node>(Node{document, child});
  }
};

JsonObject::JsonObject(const std::filesystem::path& path) : where_(path.string()) {
  const auto document = std::make_shared<const Value>(Parse(path));
  node_ = std::make_shared<Node>(Node{document, *document});
}

JsonObject::JsonObject(std::shared_ptr<const Node> node, std::string where)
    : node_(std::move(node)), where_(std::move(where)) {
  if (!node_->value.is_object()) throw InputError(where_, "is no JSON object", "mend the file");
}

bool JsonObject::Has(const std::string& key) const { return node_->value.contains(key); }

bool JsonObject::HasObject(const std::string& key) const {
  return Has(key) && node_->value.at(key).is_object();
}

Error JsonObject::Wrong(const std::string& key, std::string_view expected) const {
  return InputError(
      where_,
      fmt::format("\"{}\" is {} {}", key, Has(key) ? "not" : "missing: there should be", expected),
      "mend the file");
}

double JsonObject::Number(const std::string& key) const {
  const Value& value = node_->At(*this, key, "a number");
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw Wrong(key, "a finite number");
  return value.get<double>();
}

int JsonObject::Whole(const std::string& key, int min, int max) const {
  const double number = Number(key);
  if (number != std::floor(number) || number < min || number > max) {
    throw Wrong(key, fmt::format("a whole number from {} to {}", min, max));
  }
  return static_cast<int>(number);
}

std::string JsonObject::Text(const std::string& key) const {
  const Value& value = node_->At(*this, key, "text");
  if (!value.is_string()) throw Wrong(key, "text");
  return value.get<std::string>();
}

JsonObject JsonObject::Object(const std::string& key) const {
  const Value& value = node_->At(*this, key, "an object");
  if (!value.is_object()) throw Wrong(key, "an object");
  return {node_->Child(value), fmt::format("{}: {}", where_, key)};
}

std::vector<JsonObject> JsonObject::Objects(const std::string& key) const {
  const Value& value = node_->At(*this, key, "a list of objects");
  if (!value.is_array()) throw Wrong(key, "a list of objects");
  std::vector<JsonObject> objects;
  for (std::size_t i = 0; i < value.size(); ++i) {
    objects.push_back(
        JsonObject(node_->Child(value[i]), fmt::format("{}: {}[{}]", where_, key, i)));
  }
  return objects;
}

std::vector<std::string> JsonObject::Texts(const std::string& key) const {
  const Value& value = node_->At(*this, key, "a list of texts");
  if (!value.is_array()) throw Wrong(key, "a list of texts");
  std::vector<std::string> texts;
  for (const Value& element : value) {
    if (!element.is_string()) throw Wrong(key, "a list of texts");
    texts.push_back(element.get<std::string>());
  }
  return texts;
}

std::vector<double> JsonObject::Numbers(const std::string& key, std::size_t count) const {
  const std::string expected = fmt::format("{} finite numbers", count);
  std::vector<double> numbers;
  bool good = true;
  Flatten(node_->At(*this, key, expected), numbers, good);
  if (!good || numbers.size() != count) throw Wrong(key, expected);
  return numbers;
}

std::vector<double> JsonObject::Numbers(const std::string& key) const {
  std::vector<double> numbers;
  bool good = true;
  Flatten(node_->At(*this, key, "a list of numbers"), numbers, good);
  if (!good) throw Wrong(key, "a list of finite numbers");
  return numbers;
}

bool JsonObject::Truth(const std::string& key) const {
  const Value& value = node_->At(*this, key, "true or false");
  if (!value.is_boolean()) throw Wrong(key, "true or false");
  return value.get<bool>();
}

bool JsonObject::HasTrue(const std::string& key) const {
  return Has(key) && node_->value.at(key).is_boolean() && node_->value.at(key).get<bool>();
}

double JsonObject::NumberOr(const std::string& key, double otherwise) const {
  return Has(key) ? Number(key) : otherwise;
}

std::string JsonObject::TextOr(const std::string& key, const std::string& otherwise) const {
  return Has(key) ? Text(key) : otherwise;
}

void JsonObject::CheckKeys(const std::vector<std::string>& known) const {
  for (const auto& item : node_->value.items()) {
    if (std::find(known.begin(), known.end(), item.key()) != known.end()) continue;
    throw InputError(where_, fmt::format("there is no key \"{}\"", item.key()),
                     fmt::format("did you mean \"{}\"?", NearestName(item.key(), known)));
  }
}

void JsonObject::CheckFormatVersion(int newest) const {
  const int version = Whole("format_version", 1, 1 << 20);
  if (version > newest) {
    throw InputError(where_, fmt::format("has format version {}, newer than {}", version, newest),
                     "use a newer lamella");
  }
}

}  // namespace lamella
