#include "pipeline/unfinished_photos.h"

#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

void Remove(const fs::path& file) {
  std::error_code error;
  fs::remove(file, error);
  if (error) {
    throw MachineError(file.string(), "can't be removed: " + error.message(),
                       "give another --out, or remove it yourself");
  }
}

}  // namespace

UnfinishedPhotos::UnfinishedPhotos(const fs::path& folder, std::string_view depend_on,
                                   const std::vector<fs::path>& photographs)
    : record_(folder / "unfinished.json") {
  const std::string text =
      nlohmann::ordered_json{{"format_version", 1}, {"photos_of", ContentHash(depend_on)}}.dump(1) +
      "\n";
  goes_on_ = fs::exists(record_) && ReadText(record_) == text;
  if (goes_on_) return;
  Remove(record_);
  Remove(folder / "photos.json");
  for (const fs::path& photograph : photographs) Remove(photograph);
  WriteTextAtomically(record_, text);
}

// Photographs are written atomically: one that is there is whole.
bool UnfinishedPhotos::Has(const fs::path& photograph) const {
  return goes_on_ && fs::exists(photograph);
}

void UnfinishedPhotos::Finish() const { Remove(record_); }

}  // namespace lamella
