// The lens sheets of a display, calibrated from a folder of photographs of its sinusoids and the
// places of their cameras.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/lattice.h"
#include "lightfield/display.h"
#include "lightfield/progress.h"
#include "pipeline/calibration_measurement.h"
#include "pipeline/solve_photos.h"

namespace lamella {

struct SolveSheetsOptions {
  std::filesystem::path patterns;  // the folder that `calibrate patterns` wrote, mode precise
  std::filesystem::path photos;    // of one camera; names sort as they were taken
  std::string display;             // name or file; "": the one in the patterns' folder
  // transforms.json in the display's frame, mm: of every position a frame named as one of its
  // photographs.
  std::filesystem::path cameras;
  double camera_sd_mm = 0.3;  // how well each coordinate of theirs is known
};

struct SolvedSheet {
  int layer = 0;
  int num_views = 0;
  bool faint = false;  // decoded by the finest sinusoid and the display's geometry alone
  LatticeReport report;
};

struct SolvedSheets {
  Display display;                    // as designed
  Calibration calibration;            // with the sheets as measured, and their panels in place
  EyeBox eye_box;                     // that lenses are known for
  std::vector<SolvedSheet> sheets;    // of every layer
  std::vector<std::string> left_out;  // photographs that were not used, and why
  std::vector<SolvedPhotos::Photo> photos;  // that were used
  std::vector<Weakness> failures() const;
};

// Whether the patterns in a folder are of a display with lenses.
bool HasLensSheets(const std::filesystem::path& patterns, const std::string& display);

// InputError where no position has all sinusoids of a panel, or one has no camera; UsageError where
// a layer has no lenses, or the display is not that of the patterns.
SolvedSheets SolveSheets(const SolveSheetsOptions& options, Progress& progress);

// Lines of text; the first says whether the calibration may be used.
std::string DescribeSheets(const SolvedSheets& solved);
CalibrationMeasurement MeasurementOf(const SolvedSheets& solved);

}  // namespace lamella
