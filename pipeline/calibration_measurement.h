// How a calibration was measured, as it stands in calibration.json beside the numbers ("measured"
// of docs/formats.md): what they are worth, which parameters were freed or held and why, and of
// which photographs they were made. calibration.md section 10.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/calibrate.h"
#include "pipeline/json_file.h"
#include "pipeline/solve_photos.h"
#include "pipeline/solve_varifocal.h"

namespace lamella {

struct CalibrationMeasurement {
  std::string program, solver;  // "lamella 0.1.0", "Ceres 2.1.0"
  // Whose pitch is the unit of length; none where the cameras' poses gave it.
  std::optional<PanelId> reference;
  EyeBox eye_box;
  double ray_rms_sd_px = 0, ray_max_sd_px = 0;  // of rays through the box
  ProbedRay worst;
  double chi2 = 0, slip_px = 0;
  std::vector<ParameterDeviation> deviations;
  struct Group {
    std::string name;
    bool freed = false;
    std::string reason;
  };
  std::vector<Group> groups;
  std::vector<SolvedPhotos::Photo> photos;
};

// How much of view k (columns) an eye in the middle of view j (rows) sees before a layer: K x K
// shares, rows sum to 1. Views and matrices are crosstalk.h's.
struct MeasuredCrosstalk {
  int layer = 0;
  double pupil_px = 0;  // of the camera: its diameter as openings throw it; 0: not known
  Eigen::MatrixXd without_pupil, with_pupil;
};

CalibrationMeasurement MeasurementOf(const SolvedPhotos& solved);
CalibrationMeasurement MeasurementOf(const SolvedVarifocal& solved);

// An object of JSON, and arrays of it.
std::string MeasurementText(const CalibrationMeasurement& measurement);
std::string DeviationsText(const std::vector<ParameterDeviation>& deviations);
std::string CrosstalkText(const std::vector<MeasuredCrosstalk>& crosstalk);
// InputError naming the field where one is unknown, absent, of another type, a deviation or the
// pupil is negative, or a matrix is not square of shares whose rows sum to 1.
CalibrationMeasurement ReadMeasurement(const JsonObject& json);
std::vector<ParameterDeviation> ReadDeviations(const JsonObject& json, const char* key);
std::vector<MeasuredCrosstalk> ReadCrosstalk(const JsonObject& json, const char* key);

}  // namespace lamella
