#include "pipeline/check_photos.h"

#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
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
  for (const NamedFile& file : files) {
    const CheckedPhoto& photo = check.Add(
        file.path.filename().string(), ExaminePhoto(ReadLuminance(file.path).span(), checked.list));
    report(photo, photo.shot ? checked.list.shots[*photo.shot].name : "");
    progress.Advance();
  }
  checked.photos = check.photos();
  checked.missing = check.Missing();
  checked.num_views = check.num_views();
  return checked;
}

}  // namespace lamella
