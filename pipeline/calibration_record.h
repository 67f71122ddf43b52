// calibration.json: a Calibration as a file (docs/formats.md), for layers, frames, preview and the
// virtual prototype.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lightfield/calibration.h"
#include "pipeline/calibration_measurement.h"

namespace lamella {

// Every number as it is: reading gives the same bits back. With a measurement where it was
// measured.
void SaveCalibration(const std::filesystem::path& file, const Calibration& calibration,
                     const std::optional<CalibrationMeasurement>& measurement = std::nullopt);
std::string CalibrationText(
    const Calibration& calibration,
    const std::optional<CalibrationMeasurement>& measurement = std::nullopt);

// Numbers that a file leaves out are as designed (0; index and gain 1; an sRGB response).
// InputError naming the file, layer and field where one is unknown, of the wrong type or absent
// without such a default, where Check refuses, or where the file is of a newer version.
Calibration LoadCalibration(const std::filesystem::path& file);
// How it was measured; nothing of designs and virtual prototypes. LoadCalibration checks it, too.
std::optional<CalibrationMeasurement> LoadMeasurement(const std::filesystem::path& file);

}  // namespace lamella
