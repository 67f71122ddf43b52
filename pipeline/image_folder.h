// The images of a folder, by the name that views have: the file's stem.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lamella {

struct NamedFile {
  std::string name;
  std::filesystem::path path;
};

// The image files (by their extension) of a folder, or the one file that is given; sorted by name.
// InputError where there is none, or two have one name.
std::vector<NamedFile> ImagesOf(const std::filesystem::path& file_or_folder);

// The same, numbers in names by their value: "view2" before "view10".
std::vector<NamedFile> ImagesByNumber(const std::filesystem::path& file_or_folder);

}  // namespace lamella
