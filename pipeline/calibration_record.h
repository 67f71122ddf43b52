// calibration.json: a Calibration as a file (docs/formats.md), for layers, frames, preview and the
// virtual prototype.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lightfield/calibration.h"
#include "pipeline/calibration_measurement.h"

namespace lamella {

// What a calibration's numbers are worth, as far as they were measured.
struct MeasuredNumbers {
  std::optional<CalibrationMeasurement> geometry;
  std::vector<ParameterDeviation> light;  // of the panels' photometry
  std::vector<MeasuredCrosstalk> crosstalk = {};
};

// Every number as it is: reading gives the same bits back.
void SaveCalibration(const std::filesystem::path& file, const Calibration& calibration,
                     const MeasuredNumbers& measured = {});
std::string CalibrationText(const Calibration& calibration, const MeasuredNumbers& measured = {});

// Numbers that a file leaves out are as designed (0; index and gain 1; an sRGB response).
// InputError naming the file, layer and field where one is unknown, of the wrong type or absent
// without such a default, where Check refuses, or where the file is of a newer version.
Calibration LoadCalibration(const std::filesystem::path& file);
// How its geometry was measured; nothing of designs and virtual prototypes. LoadCalibration checks
// it, too.
std::optional<CalibrationMeasurement> LoadMeasurement(const std::filesystem::path& file);
// Deviations of its panels' photometry and its layers' crosstalk, likewise.
std::vector<ParameterDeviation> LoadLightDeviations(const std::filesystem::path& file);
std::vector<MeasuredCrosstalk> LoadCrosstalk(const std::filesystem::path& file);

}  // namespace lamella
