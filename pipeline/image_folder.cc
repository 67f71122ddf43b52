#include "pipeline/image_folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

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

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Length of the digits at the front.
std::size_t Digits(std::string_view text) {
  return static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), IsDigit) -
                                  text.begin());
}

std::string_view WithoutZeros(std::string_view digits) {
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

// Numbers in names by their value: "view2" before "view10".
bool ComesBefore(std::string_view a, std::string_view b) {
  while (!a.empty() && !b.empty()) {
    const std::size_t digits_a = Digits(a), digits_b = Digits(b);
    if (digits_a > 0 && digits_b > 0) {
      const std::string_view x = WithoutZeros(a.substr(0, digits_a));
      const std::string_view y = WithoutZeros(b.substr(0, digits_b));
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      a.remove_prefix(digits_a);
      b.remove_prefix(digits_b);
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.size() < b.size();
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

std::vector<NamedFile> ImagesByNumber(const fs::path& file_or_folder) {
  std::vector<NamedFile> files = ImagesOf(file_or_folder);
  std::stable_sort(files.begin(), files.end(), [](const NamedFile& a, const NamedFile& b) {
    return ComesBefore(a.name, b.name);
  });
  return files;
}

}  // namespace lamella
