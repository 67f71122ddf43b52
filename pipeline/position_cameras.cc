#include "pipeline/position_cameras.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/capture/transforms_json.h"

namespace lamella {
namespace fs = std::filesystem;

std::map<int, View> CamerasOfPositions(const CheckedPhotos& checked, const fs::path& file) {
  if (file.empty()) {
    throw UsageError("--cameras", "is missing: under lenses nothing tells where the camera stood",
                     "give a transforms.json in the display's frame, in mm");
  }
  std::map<std::string, View> named;
  for (View& view : ReadTransformsJson(file).views) {
    named.emplace(view.image.stem().string(), view);
    named.emplace(view.name, std::move(view));
  }
  std::map<int, View> cameras;
  for (const CheckedPhoto& photo : checked.photos) {
    const auto found = named.find(fs::path(photo.photo).stem().string());
    if (found == named.end()) continue;
    const Camera& camera = found->second.camera;
    if (camera.width != photo.facts.width || camera.height != photo.facts.height) {
      throw InputError(
          file.string(),
          fmt::format("has a camera of {} x {} px for {}, which is {} x {}", camera.width,
                      camera.height, photo.photo, photo.facts.width, photo.facts.height),
          "give the cameras of the photographs as they are");
    }
    cameras.emplace(photo.view, found->second);
  }
  return cameras;
}

const View& CameraOfPosition(const std::map<int, View>& cameras, int position,
                             const CheckedPhotos& checked, const fs::path& file) {
  const auto found = cameras.find(position);
  if (found != cameras.end()) return found->second;
  const auto first =
      std::find_if(checked.photos.begin(), checked.photos.end(),
                   [&](const CheckedPhoto& photo) { return photo.view == position; });
  throw InputError(file.string(),
                   fmt::format("has no frame of position {} ({} and others)", position + 1,
                               first == checked.photos.end() ? "" : first->photo),
                   "add one that is named as any of its photographs");
}

bool IsComplete(const CheckedPhotos& checked, int position) {
  std::size_t good = 0, all = 0;
  for (const CheckedPhoto& photo : checked.photos) {
    if (photo.view != position) continue;
    ++all;
    if (photo.shot && photo.good) ++good;
  }
  return good == checked.list.shots.size() && all == good;
}

std::string IncompletePosition(int position) {
  return fmt::format("position {}: its photographs are not every shot, good, and nothing else",
                     position + 1);
}

}  // namespace lamella
