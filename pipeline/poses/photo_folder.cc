#include "pipeline/poses/photo_folder.h"

#include <algorithm>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// COLMAP tells formats by their extension.
std::string SafeName(std::size_t index, const CapturedView& view) {
  std::string extension = view.file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return fmt::format("{:06}{}", index, view.is_plain ? extension : ".png");
}

// A link, or a copy on file systems that have no links.
void Link(const fs::path& original, const fs::path& file) {
  std::error_code error;
  fs::create_symlink(original, file, error);
  if (error) fs::copy_file(original, file, error);
  if (error) {
    throw MachineError(file.string(), "can't be written (" + error.message() + ")",
                       "check permissions and free space, then run the same command again");
  }
}

}  // namespace

std::vector<std::string> MakePhotoFolder(const CaptureRecord& capture, const fs::path& folder,
                                         Progress& progress) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < capture.views.size(); ++i) {
    names.push_back(SafeName(i, capture.views[i]));
  }
  progress.Start("prepare photographs", static_cast<std::int64_t>(names.size()), "views");
  ParallelForEach(0, static_cast<std::int64_t>(names.size()), [&](std::int64_t i) {
    const auto index = static_cast<std::size_t>(i);
    const CapturedView& view = capture.views[index];
    if (view.is_plain) {
      Link(view.file, folder / names[index]);
    } else {
      WriteCodes8(folder / names[index], ReadSrgb8(view.file).span());
    }
    progress.Advance();
  });
  return names;
}

}  // namespace lamella
