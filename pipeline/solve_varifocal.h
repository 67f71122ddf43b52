// A varifocal display's calibration from photographs of its planes, one lit at a time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/varifocal.h"
#include "lightfield/display.h"
#include "lightfield/progress.h"
#include "pipeline/solve_photos.h"

namespace lamella {

struct SolvedVarifocal {
  Display display;  // as designed
  VarifocalReport report;
  std::vector<std::string> left_out;        // photographs that were not used, and why
  std::vector<SolvedPhotos::Photo> photos;  // that were used
};

// Poses and lenses of the photographs are those of `cameras`, a transforms.json in the display's
// frame (mm), one camera position with one pose; the calibration stands in the same frame.
// UsageError where there is none or the display is not that of the patterns; InputError where no
// photograph shows a plane, or one of a position has no pose.
SolvedVarifocal SolveVarifocalPhotos(const SolvePhotosOptions& options,
                                     const std::filesystem::path& cameras, Progress& progress);

// Lines of text; the first says whether the calibration may be used.
std::string DescribeVarifocal(const SolvedVarifocal& solved);

}  // namespace lamella
