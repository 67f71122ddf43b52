// capture/capture.json: the views of a capture and what is known of each before any matching.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lightfield/view.h"
#include "pipeline/workspace.h"

namespace lamella {

enum class CameraOrigin {
  kKnown,  // given with the capture: held
  kExif,   // focal length of the EXIF data: a start that is refined
  kGuess   // 1.2 times the longer side: nothing is known
};

struct CapturedView {
  std::string name;            // its file's stem; unique
  std::filesystem::path file;  // absolute
  std::string sha256;
  int orientation = 1;   // EXIF; sizes and cameras are of the upright picture
  bool is_plain = true;  // 8-bit JPEG or PNG, upright: any program reads its pixels as we do
  std::string device;  // maker, model and focal length; views of one device and size share a camera
  CameraOrigin camera_origin = CameraOrigin::kGuess;
  Camera camera;
  std::optional<Rigid> camera_from_world;  // known pose
  std::optional<GridPosition> grid;
  std::filesystem::path depth = {};  // that came with the capture, absolute; empty: none
  std::string depth_sha256 = {};
};

struct CaptureRecord {
  std::vector<CapturedView> views;  // by name
};

void SaveCapture(const std::filesystem::path& capture_folder, const CaptureRecord& record);
// InputError where the file is absent, broken or of a newer version.
CaptureRecord LoadCapture(const Workspace& workspace);

// The views as posed ones; nothing where a pose is missing.
std::optional<std::vector<View>> KnownViews(const CaptureRecord& record);

}  // namespace lamella
