#include "pipeline/capture/known_cameras.h"

#include <algorithm>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/capture/hci_grid.h"
#include "pipeline/capture/strecha_camera.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/poses/model.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

std::vector<View> ReadAnyFormat(const fs::path& path) {
  if (IsTransformsJson(path)) return ReadTransformsJson(path).views;
  if (IsHciGrid(path)) return ReadHciGrid(path);
  if (IsColmapModel(path)) return ViewsOf(ReadColmapModel(path));
  if (IsStrechaFolder(path)) return ReadStrechaFolder(path);
  throw InputError(path.string(),
                   fs::exists(path) ? "holds no cameras that are known here" : "does not exist",
                   "give a transforms.json, or a folder of .camera files, of an HCI grid or of a "
                   "COLMAP model");
}

}  // namespace

std::vector<View> ReadKnownCameras(const fs::path& file_or_folder) {
  std::vector<View> views = ReadAnyFormat(file_or_folder);
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
  for (std::size_t i = 1; i < views.size(); ++i) {
    if (views[i].name == views[i - 1].name) {
      throw InputError(file_or_folder.string(),
                       fmt::format("has two cameras named \"{}\"", views[i].name),
                       "rename one: a view's name is its file's stem");
    }
  }
  return views;
}

}  // namespace lamella
