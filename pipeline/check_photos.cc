#include "pipeline/check_photos.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/errors_of_each.h"
#include "pipeline/image_folder.h"
#include "pipeline/photo_numbers.h"

namespace lamella {
namespace fs = std::filesystem;

CheckedPhotos CheckPhotos(
    const fs::path& patterns, const fs::path& photos,
    const std::function<void(const CheckedPhoto&, const std::string&)>& report,
    Progress& progress) {
  CheckedPhotos checked;
  checked.list = LoadShotList(patterns);
  if (checked.list.mode == CalibrationMode::kPhotometry) {
    throw UsageError(patterns.string(), "has patterns of photometry, which say nothing of geometry",
                     "use lamella calibrate photometry, or give patterns of quick or precise");
  }
  PhotoCheck check(checked.list);
  const std::vector<NamedFile> files = ImagesOf(photos);
  progress.Start("photographs", static_cast<std::int64_t>(files.size()), "photographs");
  const auto at_once = static_cast<std::size_t>(NumThreads());
  for (std::size_t first = 0; first < files.size(); first += at_once) {
    const std::span<const NamedFile> some =
        std::span(files).subspan(first, std::min(at_once, files.size() - first));
    std::vector<PhotoFacts> facts(some.size());
    const auto errors = ErrorsOfEach(some.size(), [&](std::size_t i) {
      facts[i] = ExaminePhoto(ReadLuminance(some[i].path).span(), checked.list);
    });
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (errors[i]) throw *errors[i];  // those before it have been reported
      const CheckedPhoto& photo = check.Add(some[i].path.filename().string(), std::move(facts[i]));
      report(photo, photo.shot ? checked.list.shots[*photo.shot].name : "");
      progress.Advance();
    }
  }
  checked.photos = check.photos();
  checked.missing = check.Missing();
  checked.num_views = check.num_views();
  return checked;
}

}  // namespace lamella
