#include "pipeline/unfinished_photos.h"

#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/hash.h"

namespace lamella {
namespace fs = std::filesystem;

UnfinishedPhotos::UnfinishedPhotos(const fs::path& folder, std::string_view depend_on)
    : record_(folder / "unfinished.json") {
  const std::string text =
      nlohmann::ordered_json{{"format_version", 1}, {"photos_of", ContentHash(depend_on)}}.dump(1) +
      "\n";
  goes_on_ = fs::exists(record_) && ReadText(record_) == text;
  WriteTextAtomically(record_, text);
}

// Photographs are written atomically: one that is there is whole.
bool UnfinishedPhotos::Has(const fs::path& photograph) const {
  return goes_on_ && fs::exists(photograph);
}

void UnfinishedPhotos::Finish() const { fs::remove(record_); }

}  // namespace lamella
