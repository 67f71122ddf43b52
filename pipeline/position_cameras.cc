#include "pipeline/position_cameras.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/observe_photos.h"

namespace lamella {
namespace fs = std::filesystem;

std::map<int, View> CamerasOfPositions(const CheckedPhotos& checked, const fs::path& file) {
  if (file.empty()) {
    throw UsageError("--cameras", "is missing: under lenses nothing tells where the camera stood",
                     "give a transforms.json in the display's frame, in mm, or use patterns with a "
                     "printed board");
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

PrintedBoard BoardOf(const CheckedPhotos& checked, double square_mm) {
  if (!checked.list.printed) {
    throw UsageError("--board-square-mm",
                     "is of a printed board, which these patterns have none of",
                     "leave it out, and give --cameras");
  }
  PrintedBoard printed = *checked.list.printed;
  if (square_mm > 0) printed.square_mm = square_mm;
  return printed;
}

std::vector<BoardPhoto> BoardPhotosOf(const CheckedPhotos& checked, const fs::path& photos) {
  CheckOneSize(checked);
  std::vector<BoardPhoto> boards;
  for (const CheckedPhoto& photo : checked.photos) {
    const bool is_board =
        photo.shot && checked.list.shots[*photo.shot].kind == PatternShot::Kind::kPrinted;
    // Corners state how well they are known: those of a board that might be seen better do no harm.
    if (!is_board || !photo.usable) continue;
    boards.push_back({photo.view, photo.photo, photo.facts.sighting->points});
  }
  if (!boards.empty()) return boards;
  throw InputError(photos.string(), "shows the printed board in no photograph",
                   "photograph it at every position, last, with the room lit; or give --cameras");
}

PhotoCamera BodyOf(const CheckedPhotos& checked, double focal_px) {
  const PhotoFacts& facts = checked.photos.front().facts;
  return {"body", facts.width, facts.height, focal_px};
}

bool IsComplete(const CheckedPhotos& checked, int position) {
  if (BoardInBetween(checked.list, checked.photos, position)) return false;
  const auto is_printed = [](const PatternShot& shot) {
    return shot.kind == PatternShot::Kind::kPrinted;
  };
  const std::vector<PatternShot>& shots = checked.list.shots;
  std::size_t good = 0, all = 0;
  for (const CheckedPhoto& photo : checked.photos) {
    if (photo.view != position || (photo.shot && is_printed(shots[*photo.shot]))) continue;
    ++all;
    if (photo.shot && photo.good) ++good;
  }
  const auto printed = std::count_if(shots.begin(), shots.end(), is_printed);
  return good == shots.size() - static_cast<std::size_t>(printed) && all == good;
}

std::vector<std::string> IncompletePositions(const CheckedPhotos& checked) {
  std::vector<std::string> lines;
  for (int position = 0; position < checked.num_views; ++position) {
    if (IsComplete(checked, position) || IsOfBoardAlone(checked.list, checked.photos, position)) {
      continue;
    }
    if (const auto board = BoardInBetween(checked.list, checked.photos, position)) {
      lines.push_back(fmt::format("position {}: {} {}", position + 1, *board, kLeaveBoardOut));
      continue;
    }
    std::string line = fmt::format(
        "position {}: its photographs are not every shot, good, and nothing else", position + 1);
    if (MayBeOfBoardAlone(checked.list, checked.photos, position)) {
      line += fmt::format("; {}", kBoardAloneNotFound);
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<std::string> PositionsWithoutBoard(const CheckedPhotos& checked,
                                               const std::vector<int>& positions) {
  std::vector<std::string> lines;
  for (int position = 0; position < checked.num_views; ++position) {
    if (!IsComplete(checked, position) ||
        std::binary_search(positions.begin(), positions.end(), position)) {
      continue;
    }
    lines.push_back(
        fmt::format("position {}: the printed board is not seen well enough", position + 1));
  }
  return lines;
}

}  // namespace lamella
