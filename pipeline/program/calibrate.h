// What the files of `lamella calibrate` share.
#pragma once

#include "pipeline/program/command_line.h"

namespace lamella {

// Each adds its verb to `lamella calibrate`.
void AddCalibrateSolve(CLI::App& calibrate, Invocation& invocation);
void AddCalibrateReport(CLI::App& calibrate, Invocation& invocation);
void AddGrayCodePatterns(CLI::App& calibrate, Invocation& invocation);
void AddGrayCode(CLI::App& calibrate, Invocation& invocation);
void AddWarp(CLI::App& calibrate, Invocation& invocation);

}  // namespace lamella
