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
  std::vector<std::string> left_out;  // photographs that were not used, and why
  std::vector<std::string> doubtful;  // used, though `calibrate check` would have them taken again
  std::vector<SolvedPhotos::Photo> photos;  // that were used
};

struct SolveVarifocalOptions {
  SolvePhotosOptions photos;
  // A transforms.json in the display's frame (mm), one camera position with one pose, taken as
  // exact; the calibration stands in the same frame. "": the patterns' printed board tells where
  // the cameras stood, and the lens, with the planes; the display's frame is then that in which the
  // planes are nearest to where they are designed.
  std::filesystem::path cameras;
  double board_square_mm = 0;  // of the printed board, as measured; 0: as drawn
};

// UsageError where there are neither cameras nor a board, or the display is not that of the
// patterns; InputError where no photograph shows a plane, or one of a position has no pose.
SolvedVarifocal SolveVarifocalPhotos(const SolveVarifocalOptions& options, Progress& progress);

// "all planes from 9 degrees to the right, 1050 mm away, after which ..."; empty where there is
// none.
std::string DescribeNextPlaneView(const VarifocalReport& report);
// Lines of text; the first says whether the calibration may be used.
std::string DescribeVarifocal(const SolvedVarifocal& solved);

}  // namespace lamella
