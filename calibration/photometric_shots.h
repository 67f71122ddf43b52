// What a display shows while its light is measured: flat levels over exposures, colours, lines
// (calibration.md section 9). Part of shot_list.h.
#pragma once

#include <string>
#include <vector>

#include "calibration/shot_list.h"
#include "lightfield/calibration.h"

namespace lamella {

// At every camera position: all black; of every layer with a modulator the boards, which tell where
// it is, and white. At the first one after these: black at the longer exposures; of every such
// layer full red, green and blue, both panels at half their codes, lines; of each of its panels 17
// levels (white is one of those above), the dark ones at 8 and 64 times the exposure as well.
// UsageError where no layer has a modulator: what lenses throw to one side is no panel's level.
std::vector<PatternShot> PhotometricShots(const Calibration& calibration);

std::string NameOfPhotometricShot(const PatternShot& shot);  // "layer0_emitter_032_x8"
std::string DescribePhotometricShot(const PatternShot& shot);
std::string ExposureText(const PatternShot& shot);  // "", or ", exposed 8 times as long"
std::string DescribePhotometry(const ShotList& list);

}  // namespace lamella
