// The lens sheets of a display, calibrated from a folder of photographs of its sinusoids and the
// places of their cameras, or photographs of a printed board that tell these.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibration/board_cameras.h"
#include "calibration/lattice.h"
#include "lightfield/display.h"
#include "lightfield/progress.h"
#include "lightfield/rigid.h"
#include "pipeline/calibration_measurement.h"
#include "pipeline/solve_photos.h"

namespace lamella {

struct SolveSheetsOptions {
  std::filesystem::path patterns;  // the folder that `calibrate patterns` wrote, mode precise
  std::filesystem::path photos;    // of one camera; names sort as they were taken
  std::string display;             // name or file; "": the one in the patterns' folder
  // transforms.json in the display's frame, mm: of every position a frame named as one of its
  // photographs. "": the patterns' printed board tells where they stood.
  std::filesystem::path cameras;
  double camera_sd_mm = 0.3;   // how well each coordinate of theirs is known, where a file has them
  double board_square_mm = 0;  // of the printed board, as measured; 0: as drawn
  double focal_px = 0;         // of a camera that the board tells, roughly; 0: found
};

struct SolvedSheet {
  int layer = 0;
  int num_views = 0;                     // positions that show it
  std::vector<int> positions;            // of all cameras, in the order of report.views_fit
  std::vector<Eigen::Vector3d> eyes_mm;  // where they stood, in the stack's frame
  bool faint = false;  // decoded by the finest sinusoid and the display's geometry alone
  LatticeReport report;
};

// What a printed board says of the cameras, and where it was found to be fixed.
struct BoardOfSheets {
  BoardCameras cameras;
  Rigid display_from_board;
};

struct SolvedSheets {
  Display display;                     // as designed
  Calibration calibration;             // with the sheets as measured, and their panels in place
  EyeBox eye_box;                      // that lenses are known for
  std::vector<SolvedSheet> sheets;     // of every layer
  std::optional<BoardOfSheets> board;  // where it tells the cameras
  std::vector<std::string> left_out;   // photographs that were not used, and why
  std::vector<SolvedPhotos::Photo> photos;  // that were used
  std::vector<Weakness> failures() const;   // where not empty it is not to be used
  std::vector<Weakness> warnings() const;
};

// Whether the patterns in a folder are of a display with lenses.
bool HasLensSheets(const std::filesystem::path& patterns, const std::string& display);

// Where a board tells the cameras, the display's frame is that in which the first panel stands as
// designed. InputError where no position has all sinusoids of a panel, or one has no camera in the
// file; UsageError where a layer has no lenses, the display is not that of the patterns, or there
// is neither a file nor a board.
SolvedSheets SolveSheets(const SolveSheetsOptions& options, Progress& progress);

// Lines of text; the first says whether the calibration may be used.
std::string DescribeSheets(const SolvedSheets& solved);
CalibrationMeasurement MeasurementOf(const SolvedSheets& solved);

}  // namespace lamella
