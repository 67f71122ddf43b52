#include "pipeline/capture/input.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/capture/hci_grid.h"
#include "pipeline/capture/known_cameras.h"
#include "pipeline/capture/photographs.h"
#include "pipeline/capture/select_views.h"
#include "pipeline/capture/strecha_camera.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/poses/model.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

fs::path Absolute(const fs::path& path) {
  fs::path absolute = fs::absolute(path).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

bool BringsCameras(const fs::path& input) { return IsHciGrid(input) || IsTransformsJson(input); }

// The input as a folder or a .json file; what names parameters.cfg means its folder.
fs::path Input(const CaptureOptions& options) {
  fs::path input = Absolute(options.input);
  std::error_code error;
  if (!fs::exists(input, error)) {
    throw InputError(options.input, "does not exist",
                     "give a folder of photographs, a grid's folder or a transforms.json");
  }
  if (input.filename() == "parameters.cfg") return input.parent_path();
  if (!fs::is_directory(input, error) && !IsTransformsJson(input)) {
    throw InputError(options.input, "is neither a folder nor a transforms.json",
                     "give the folder that holds the photographs");
  }
  return input;
}

// For a folder without images: the one below it that has some.
std::string Suggestion(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && !ListImages(entry.path()).empty()) {
      return "did you mean " + entry.path().string() + "?";
    }
  }
  return "put photographs (JPEG, PNG, TIFF or EXR) there";
}

std::vector<CapturedView> ListPhotographs(const fs::path& folder) {
  std::vector<CapturedView> views;
  for (const fs::path& file : ListImages(folder)) {
    CapturedView view;
    view.name = file.stem().string();
    view.file = file;
    views.push_back(std::move(view));
  }
  if (views.empty()) throw InputError(folder.string(), "holds no image", Suggestion(folder));
  return views;
}

void SetKnown(CapturedView& view, const View& known) {
  view.camera_origin = CameraOrigin::kKnown;
  view.camera = known.camera;
  view.camera_from_world = known.camera_from_world;
  view.grid = known.grid;
  view.depth = known.depth;
}

std::vector<CapturedView> ListKnown(const fs::path& input) {
  std::vector<CapturedView> views;
  for (const View& known : ReadKnownCameras(input)) {
    CapturedView view;
    view.name = known.name;
    view.file = known.image;
    SetKnown(view, known);
    views.push_back(std::move(view));
  }
  if (views.empty()) throw InputError(input.string(), "lists no image", "give another capture");
  return views;
}

void SortByName(std::vector<CapturedView>& views) {
  std::sort(views.begin(), views.end(), [](const CapturedView& a, const CapturedView& b) {
    return std::pair(a.name, a.file) < std::pair(b.name, b.file);
  });
  for (std::size_t i = 1; i < views.size(); ++i) {
    if (views[i].name != views[i - 1].name) continue;
    throw InputError(views[i].file.string(),
                     "has the name of another view, " + views[i - 1].file.filename().string(),
                     "rename one of them: a view's name is its file's stem");
  }
}

void Select(std::vector<CapturedView>& views, const std::string& patterns) {
  if (patterns.empty()) return;
  std::vector<std::string> names;
  for (const CapturedView& view : views) names.push_back(view.name);
  const std::vector<bool> chosen = SelectViews(names, patterns);
  std::vector<CapturedView> kept;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (chosen[i]) kept.push_back(std::move(views[i]));
  }
  views = std::move(kept);
}

void AttachCameras(std::vector<CapturedView>& views, const fs::path& cameras) {
  std::map<std::string, View> known;
  for (View& view : ReadKnownCameras(cameras)) known.emplace(view.name, std::move(view));
  for (CapturedView& view : views) {
    const auto camera = known.find(view.name);
    if (camera == known.end()) {
      throw InputError(cameras.string(), fmt::format("has no camera for \"{}\"", view.name),
                       fmt::format("add it or leave the view out with --views '!{}'", view.name));
    }
    SetKnown(view, camera->second);
    view.grid.reset();
  }
}

}  // namespace

std::vector<CapturedView> ListViews(const CaptureOptions& options) {
  const fs::path input = Input(options);
  const bool brings_cameras = BringsCameras(input);
  if (brings_cameras && !options.cameras.empty()) {
    throw UsageError("--cameras", options.input + " brings its own cameras",
                     "leave the option out");
  }
  std::vector<CapturedView> views = brings_cameras ? ListKnown(input) : ListPhotographs(input);
  SortByName(views);
  Select(views, options.views);
  if (!options.cameras.empty()) AttachCameras(views, Absolute(options.cameras));
  if (views.size() < 2) {
    throw InputError(options.input, fmt::format("only one view, \"{}\"", views[0].name),
                     "at least two are needed: depth comes from their parallax");
  }
  return views;
}

std::vector<fs::path> CameraFiles(const CaptureOptions& options) {
  std::vector<fs::path> files;
  const auto add = [&](const fs::path& path) {
    if (IsTransformsJson(path)) {
      files.push_back(fs::is_directory(path) ? path / "transforms.json" : path);
    } else if (IsHciGrid(path)) {
      files.push_back(path / "parameters.cfg");
    } else if (fs::is_directory(path)) {
      for (const auto& entry : fs::directory_iterator(path)) {
        const bool model = IsColmapModel(path) && !entry.is_directory();
        if (model || entry.path().extension() == ".camera") files.push_back(entry.path());
      }
    }
  };
  const fs::path input = Input(options);
  if (BringsCameras(input)) add(input);
  if (!options.cameras.empty()) add(Absolute(options.cameras));
  std::sort(files.begin(), files.end());
  return files;
}

bool NeedsColmap(const CaptureOptions& options) {
  const fs::path input = Input(options);
  if (IsHciGrid(input)) return false;
  if (!IsTransformsJson(input)) return true;
  return !FindRegularGrid(ReadKnownCameras(input));
}

}  // namespace lamella
