// Photographs of a calibration's patterns, read and judged.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "calibration/photo_check.h"
#include "lightfield/progress.h"

namespace lamella {

struct CheckedPhotos {
  ShotList list;
  std::vector<CheckedPhoto> photos;
  std::vector<std::string> missing;  // a line per camera position
  int num_views = 0;
};

// The images of `photos` (a folder, or one file) by their names, which must sort as they were
// taken. `report` is given each as soon as it is judged, with the name of its shot ("" where it is
// none).
CheckedPhotos CheckPhotos(
    const std::filesystem::path& patterns, const std::filesystem::path& photos,
    const std::function<void(const CheckedPhoto&, const std::string& shot)>& report,
    Progress& progress);

}  // namespace lamella
