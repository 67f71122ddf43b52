#include "pipeline/image_folder.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "lightfield/error.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

bool IsImage(const fs::path& path) {
  constexpr std::array kExtensions{".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"};
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace

std::vector<NamedFile> ImagesOf(const fs::path& file_or_folder) {
  std::error_code error;
  if (fs::is_regular_file(file_or_folder, error)) {
    return {{file_or_folder.stem().string(), file_or_folder}};
  }
  if (!fs::is_directory(file_or_folder, error)) {
    throw InputError(file_or_folder.string(), "is no file or folder", "give images that exist");
  }
  std::vector<NamedFile> files;
  for (const auto& entry : fs::directory_iterator(file_or_folder)) {
    if (entry.is_regular_file() && IsImage(entry.path())) {
      files.push_back({entry.path().stem().string(), entry.path()});
    }
  }
  std::sort(files.begin(), files.end(), [](const NamedFile& a, const NamedFile& b) {
    return a.path.filename() < b.path.filename();
  });
  std::stable_sort(files.begin(), files.end(),
                   [](const NamedFile& a, const NamedFile& b) { return a.name < b.name; });
  if (files.empty()) {
    throw InputError(file_or_folder.string(), "holds no image (png, jpg, tif, exr)",
                     "give a folder of images");
  }
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (files[i].name == files[i - 1].name) {
      throw InputError(file_or_folder.string(), "holds two images named \"" + files[i].name + "\"",
                       "move one of them away: names are matched without their extension");
    }
  }
  return files;
}

}  // namespace lamella
