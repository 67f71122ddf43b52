// The stage capture: lists the views of a capture and checks that every image opens whole.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/capture/hci_grid.h"
#include "pipeline/capture/input.h"
#include "pipeline/capture/photographs.h"
#include "pipeline/capture_record.h"
#include "pipeline/errors_of_each.h"
#include "pipeline/stages.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// The camera of the size of the image: known cameras may be of a larger or smaller copy.
Camera FitToImage(const Camera& camera, const ImageInfo& info, const fs::path& file) {
  const double sx = static_cast<double>(info.width) / camera.width;
  const double sy = static_cast<double>(info.height) / camera.height;
  if (std::abs(camera.height * sx - info.height) > 1) {
    throw InputError(file.string(),
                     fmt::format("is {}x{} px, but its camera is of an image of {}x{} px",
                                 info.width, info.height, camera.width, camera.height),
                     "give the camera of this image");
  }
  Camera fitted = camera;
  fitted.width = info.width;
  fitted.height = info.height;
  fitted.fx *= sx;
  fitted.cx *= sx;
  fitted.fy *= sy;
  fitted.cy *= sy;
  return fitted;
}

Camera GuessedCamera(const ImageInfo& info, double focal_px) {
  return {.width = info.width,
          .height = info.height,
          .fx = focal_px,
          .fy = focal_px,
          .cx = info.width / 2.0,
          .cy = info.height / 2.0};
}

bool IsPlain(const ImageInfo& info) {
  return (info.format == "jpeg" || info.format == "png") && info.bits == 8 && !info.is_float &&
         info.orientation == 1 && (info.channels == 3 || info.channels == 1);
}

// Other tools name depth, too, and it is often left behind. Only --depth given needs it, and says
// which file is missing.
bool HasDepth(const CapturedView& view) {
  std::error_code error;
  return !view.depth.empty() && fs::exists(view.depth, error);
}

// Depth in another form than depth_file_path has is written anew in that form below `folder`.
void TakeDepth(const fs::path& folder, CapturedView& view) {
  if (!HasDepth(view)) return;
  if (IsHciDisparity(view.depth)) {
    std::vector<Channel> channels;
    channels.push_back({"Z", ReadHciDepth(view.depth)});
    CreateFolder(folder / "depth");
    view.depth = folder / "depth" / (view.name + ".exr");
    WriteExr(view.depth, channels, ExrType::kFloat);
  }
  view.depth_sha256 = Sha256OfFile(view.depth);
}

// What the image itself tells; throws where it does not open whole.
ImageInfo Inspect(CapturedView& view) {
  ImageInfo info = ReadImageInfo(view.file);
  CheckImageIsWhole(view.file);
  view.sha256 = Sha256OfFile(view.file);
  view.orientation = info.orientation;
  view.is_plain = IsPlain(info);
  view.device = DeviceName(info);
  return info;
}

// All views side by side; where several fail, the first one by name is told.
std::vector<ImageInfo> InspectAll(std::vector<CapturedView>& views, Progress& progress) {
  progress.Start("check images", static_cast<std::int64_t>(views.size()), "views");
  std::vector<ImageInfo> infos(views.size());
  ThrowFirst(ErrorsOfEach(views.size(), [&](std::size_t i) {
    infos[i] = Inspect(views[i]);
    progress.Advance();
  }));
  return infos;
}

void SetCamera(CapturedView& view, const ImageInfo& info) {
  if (view.camera_origin == CameraOrigin::kKnown) {
    view.camera = FitToImage(view.camera, info, view.file);
    return;
  }
  const FocalGuess guess = GuessFocal(info);
  view.camera = GuessedCamera(info, guess.focal_px);
  view.camera_origin = guess.origin;
}

// Photographs may differ in size, the views of a grid may not. The odd one out is named.
void CheckSizesOfGrid(const std::vector<CapturedView>& views, const std::vector<ImageInfo>& infos) {
  std::map<std::pair<int, int>, int> counts;
  for (const ImageInfo& info : infos) ++counts[{info.width, info.height}];
  const auto usual =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      })->first;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (std::pair(infos[i].width, infos[i].height) == usual) continue;
    throw InputError(
        views[i].file.string(),
        fmt::format("has another size, {}x{} px, than the grid's other views, {}x{} px",
                    infos[i].width, infos[i].height, usual.first, usual.second),
        "give all views of a grid in one size");
  }
}

StageReport Report(const std::vector<CapturedView>& views, bool grid) {
  const auto count = [&](CameraOrigin origin) {
    return std::count_if(views.begin(), views.end(),
                         [&](const CapturedView& view) { return view.camera_origin == origin; });
  };
  StageReport report;
  report.summary = {
      {"views", fmt::format("{}", views.size())},
      {"kind", grid ? "camera grid" : "photographs"},
      {"size", fmt::format("{}x{} px", views[0].camera.width, views[0].camera.height)},
      {"cameras", fmt::format("{} known, {} from EXIF, {} guessed", count(CameraOrigin::kKnown),
                              count(CameraOrigin::kExif), count(CameraOrigin::kGuess))}};
  return report;
}

}  // namespace

OptionTable Describe(CaptureOptions& options) {
  return {"capture",
          {{.name = "input",
            .help = "folder of photographs, folder of a camera grid, or transforms.json",
            .value = &options.input},
           {.name = "views",
            .help = "a part of the capture: NAME|GLOB|!NAME,... (!NAME leaves a view out)",
            .value = &options.views,
            .flag = "--views"},
           {.name = "cameras",
            .help = "known cameras of photographs: transforms.json or a folder of .camera files",
            .value = &options.cameras,
            .flag = "--cameras"}}};
}

std::string HashCaptureInput(const CaptureOptions& options) {
  std::vector<fs::path> files = CameraFiles(options);
  for (const CapturedView& view : ListViews(options)) {
    files.push_back(view.file);
    if (HasDepth(view)) files.push_back(view.depth);
  }
  std::vector<std::string> hashes(files.size());
  ParallelForEach(0, static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    const auto index = static_cast<std::size_t>(i);
    hashes[index] = files[index].string() + " " + ContentHashOfFile(files[index]) + "\n";
  });
  std::string all;
  for (const std::string& hash : hashes) all += hash;
  return ContentHash(all);
}

StageReport RunCapture(const Workspace&, const CaptureOptions& options, StageRun& run,
                       Progress& progress) {
  CaptureRecord record{ListViews(options)};
  const bool grid = std::all_of(record.views.begin(), record.views.end(),
                                [](const CapturedView& view) { return view.grid.has_value(); });
  const std::vector<ImageInfo> infos = InspectAll(record.views, progress);
  if (grid) CheckSizesOfGrid(record.views, infos);
  for (std::size_t i = 0; i < infos.size(); ++i) {
    SetCamera(record.views[i], infos[i]);
    TakeDepth(run.folder(), record.views[i]);
  }
  SaveCapture(run.folder(), record);
  return Report(record.views, grid);
}

}  // namespace lamella
