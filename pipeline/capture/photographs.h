// A folder of photographs, and what their EXIF data say of the camera.
#pragma once

#include <filesystem>
#include <vector>

#include "lightfield/image_io.h"
#include "pipeline/capture_record.h"

namespace lamella {

// The files that claim, by their extension, to be images that are read here; sorted. Hidden files
// and all others are left out.
std::vector<std::filesystem::path> ListImages(const std::filesystem::path& folder);

// The focal length in px and where it is from. From the 35 mm equivalent over the diagonal (CIPA
// DCG-001), else from the focal length and the sensor's resolution, else 1.2 times the longer side.
struct FocalGuess {
  double focal_px = 0;
  CameraOrigin origin = CameraOrigin::kGuess;
};
FocalGuess GuessFocal(const ImageInfo& info);

// Maker, model and focal length; empty where EXIF says nothing.
std::string DeviceName(const ImageInfo& info);

}  // namespace lamella
