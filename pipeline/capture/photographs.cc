#include "pipeline/capture/photographs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 9> kExtensions = {".jpg", ".jpeg", ".png",  ".tif", ".tiff",
                                                    ".exr", ".bmp",  ".webp", ".ppm"};

bool ClaimsToBeImage(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end() &&
         file.filename().string()[0] != '.';
}

}  // namespace

std::vector<fs::path> ListImages(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (ClaimsToBeImage(entry.path()) && !entry.is_directory()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

FocalGuess GuessFocal(const ImageInfo& info) {
  const double longer = std::max(info.width, info.height);
  const double diagonal = std::hypot(info.width, info.height);
  double focal = 0;
  if (info.focal_35mm) {
    focal = *info.focal_35mm / std::hypot(36.0, 24.0) * diagonal;
  } else if (info.focal_mm && info.sensor_longer_mm) {
    focal = *info.focal_mm / *info.sensor_longer_mm * longer;
  }
  // What no lens has is a wrong entry.
  if (focal > 0.1 * longer && focal < 100 * longer) return {focal, CameraOrigin::kExif};
  return {1.2 * longer, CameraOrigin::kGuess};
}

std::string DeviceName(const ImageInfo& info) {
  if (info.camera_model.empty() && !info.focal_mm) return "";
  return fmt::format("{} {} {:g} mm", info.camera_maker, info.camera_model,
                     info.focal_mm.value_or(0));
}

}  // namespace lamella
