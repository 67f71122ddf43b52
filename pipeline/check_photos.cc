#include "pipeline/check_photos.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <span>
#include <utility>
#include <vector>

#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/image_folder.h"

namespace lamella {
namespace fs = std::filesystem;

Image<float> ReadLuminance(const fs::path& file) {
  const Image<Rgb> light = ReadImage(file);
  Image<float> luminance(light.width(), light.height());
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    luminance.data()[i] = Luminance(light.data()[i]);
  }
  return luminance;
}

Image<float> ReadMeanLight(const fs::path& file) {
  const Image<Rgb> light = ReadImage(file);
  Image<float> mean(light.width(), light.height());
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const Rgb& pixel = light.data()[i];
    mean.data()[i] = (pixel.r + pixel.g + pixel.b) / 3;
  }
  return mean;
}

namespace {

// What each of some photographs shows, or why it can't be read: that is for its turn to say.
struct Examined {
  PhotoFacts facts;
  std::exception_ptr unreadable;
};
std::vector<Examined> Examine(std::span<const NamedFile> files, const ShotList& list) {
  std::vector<Examined> examined(files.size());
  ParallelForEach(0, static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    const auto index = static_cast<std::size_t>(i);
    try {
      examined[index].facts = ExaminePhoto(ReadLuminance(files[index].path).span(), list);
    } catch (...) {
      examined[index].unreadable = std::current_exception();
    }
  });
  return examined;
}

}  // namespace

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
    std::vector<Examined> examined = Examine(some, checked.list);
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (examined[i].unreadable) std::rethrow_exception(examined[i].unreadable);
      const CheckedPhoto& photo =
          check.Add(some[i].path.filename().string(), std::move(examined[i].facts));
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
