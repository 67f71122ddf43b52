// Photographs of a run that was stopped are kept by the next one that asks for the same.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace lamella {

// A folder in which photographs are being written: unfinished.json in it says what they are of, as
// a hash of all that they depend on, until they are finished.
class UnfinishedPhotos {
 public:
  // `folder` exists. Where it is not of a run for the same that was stopped, those of `photographs`
  // that are there are of something else: they and photos.json are removed. MachineError where that
  // is not possible.
  UnfinishedPhotos(const std::filesystem::path& folder, std::string_view depend_on,
                   const std::vector<std::filesystem::path>& photographs);
  // Such a photograph is in the folder already, whole.
  bool Has(const std::filesystem::path& photograph) const;
  void Finish() const;

 private:
  std::filesystem::path record_;
  bool goes_on_ = false;  // a run for the same was stopped here
};

}  // namespace lamella
