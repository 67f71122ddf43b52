// What a calibration found, for people: how well it fits, what it leaves open, what was left out.
#pragma once

#include <string>

#include "calibration/calibrate.h"

namespace lamella {

// Lines of text; the first says whether the calibration may be used.
std::string DescribeCalibration(const CalibrationReport& report);

}  // namespace lamella
