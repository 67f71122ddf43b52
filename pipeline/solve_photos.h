// A display's calibration from a folder of photographs of its patterns.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "lightfield/display.h"
#include "lightfield/progress.h"

namespace lamella {

struct SolvePhotosOptions {
  std::filesystem::path patterns;  // the folder that `calibrate patterns` wrote
  std::filesystem::path photos;    // of one camera; names sort as they were taken
  std::string display;             // name or file; "": the one in the patterns' folder
  double focal_px = 0;             // of the camera, roughly; 0: found
};

struct SolvedPhotos {
  Display display;  // as designed
  CalibrationReport report;
  std::vector<std::string> left_out;  // photographs and positions that were not used, and why
  std::vector<std::string> doubtful;  // used, though `calibrate check` would have them taken again
  struct Photo {
    std::string file, sha256;
  };
  std::vector<Photo> photos;  // that were used
};

// Photographs by name with their hashes; `photos` is their folder, or one of them.
std::vector<SolvedPhotos::Photo> HashPhotos(const std::set<std::string>& names,
                                            const std::filesystem::path& photos);

// Rays are asked for in the box in which eyes see the display cleanly, at least 65 mm wide and
// high, from 0.8 to 1.2 viewing distances. InputError where no photograph shows a pattern of this
// display, or Calibrate finds no start; UsageError where the display is not that of the patterns.
SolvedPhotos SolvePhotos(const SolvePhotosOptions& options, Progress& progress);

}  // namespace lamella
