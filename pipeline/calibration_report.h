// What a calibration found, for people: how well it fits, what it leaves open, what was left out.
#pragma once

#include <string>
#include <vector>

#include "pipeline/solve_photos.h"

namespace lamella {

// Lines of text; the first says whether the calibration may be used.
std::string DescribeCalibration(const SolvedPhotos& solved);
// A heading and what follows it, as all reports have them; "" where there is nothing.
std::string DescribeWeaknesses(const char* title, const std::vector<Weakness>& weaknesses);
std::string DescribeLines(const char* title, const std::vector<std::string>& lines);
// "20 degrees to the right and 10 degrees above, 1050 mm away".
std::string DescribePlace(double right_deg, double up_deg, double distance_mm);
// "all panels from 20 degrees to the right ..., 1050 mm away, after which ..."; empty where there
// is none.
std::string DescribeNextView(const CalibrationReport& report);

}  // namespace lamella
