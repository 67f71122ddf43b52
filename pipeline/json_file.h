// JSON files read with errors that name the file and the field.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lightfield/error.h"

namespace lamella {

// An object of a JSON file that knows where it stands, e.g. "transforms.json: frames[3]".
class JsonObject {
 public:
  // Reads the file; InputError where it is no JSON object.
  explicit JsonObject(const std::filesystem::path& path);

  bool Has(const std::string& key) const;
  bool HasObject(const std::string& key) const;  // and it is an object
  const std::string& where() const { return where_; }
  Error Wrong(const std::string& key, std::string_view expected) const;

  // InputError where the field is absent, has another type or is not finite.
  double Number(const std::string& key) const;
  int Whole(const std::string& key, int min, int max) const;
  std::string Text(const std::string& key) const;
  JsonObject Object(const std::string& key) const;
  std::vector<JsonObject> Objects(const std::string& key) const;
  std::vector<std::string> Texts(const std::string& key) const;
  // Numbers of a list, or of a list of lists (by rows); `count` of them.
  std::vector<double> Numbers(const std::string& key, std::size_t count) const;
  std::vector<double> Numbers(const std::string& key) const;  // however many
  bool Truth(const std::string& key) const;
  // False where the field is absent.
  bool HasTrue(const std::string& key) const;
  double NumberOr(const std::string& key, double otherwise) const;
  std::string TextOr(const std::string& key, const std::string& otherwise) const;

  // Refuses a key that is none of these, and offers the nearest.
  void CheckKeys(const std::vector<std::string>& known) const;
  // Refuses a file of a format newer than `newest`, or of none where one is due.
  void CheckFormatVersion(int newest) const;

 private:
  struct Node;  // a value in its document
  JsonObject(std::shared_ptr<const Node> node, std::string where);

  std::shared_ptr<const Node> node_;
  std::string where_;
};

}  // namespace lamella
