// A display's light from photographs: responses and black levels of its panels, their colours
// matched, crosstalk, fall-off (calibration.md section 9), put into its calibration.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "lightfield/calibration.h"
#include "lightfield/progress.h"
#include "pipeline/calibration_measurement.h"
#include "pipeline/photometric_photos.h"

namespace lamella {

struct MeasurePhotometryOptions {
  std::filesystem::path patterns;     // that `calibrate patterns --mode photometry` wrote
  std::filesystem::path photos;       // a folder; names sort as they were taken
  std::filesystem::path calibration;  // what is known of the display's geometry; empty: as designed
  PhotoCurve curve = PhotoCurve::kLinear;  // of integer files
  double focal_px = 0;                     // of the camera, roughly; 0: found
  double pupil_mm = 0;     // diameter of its entrance pupil: focal length by f-number
  double pupil_sd = 0.02;  // how well that is known, a share of it: f-numbers are rounded
};

struct MeasuredPhotometry {
  Calibration calibration;                     // the given one with the panels' light in it
  std::vector<ParameterDeviation> deviations;  // of numbers that were measured
  std::vector<MeasuredCrosstalk> crosstalk;    // of the layers whose lines were large enough
  std::vector<std::string> lines;              // what was found, how well it is known
  std::vector<std::string> warnings;           // what keeps it from being all that it could be
};

// With fewer than three camera positions the fall-off stays as it is, and the layers' colours are
// compared as they were seen. InputError or UsageError with one line; among others where exposures
// come out unlike what they were meant to be, as of files with a tone curve.
MeasuredPhotometry MeasurePhotometry(const MeasurePhotometryOptions& options, Progress& progress);

}  // namespace lamella
