// Photographs of a run that was stopped are kept by the next one that asks for the same.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lamella {

// A folder in which photographs are being written: unfinished.json in it says what they are of, as
// a hash of all that they depend on, until they are finished.
class UnfinishedPhotos {
 public:
  // `folder` exists.
  UnfinishedPhotos(const std::filesystem::path& folder, std::string_view depend_on);
  // Such a photograph is in the folder already, whole.
  bool Has(const std::filesystem::path& photograph) const;
  void Finish() const;

 private:
  std::filesystem::path record_;
  bool goes_on_ = false;  // a run for the same was stopped here
};

}  // namespace lamella
