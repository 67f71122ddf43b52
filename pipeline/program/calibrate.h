// What the files of `lamella calibrate` share.
#pragma once

#include <filesystem>

#include "pipeline/program/command_line.h"

namespace lamella {

// UsageError or MachineError where a file can't be written: said before the minutes that its
// content takes.
void CheckWritable(const std::filesystem::path& file);

// Each adds its verb to `lamella calibrate`.
void AddCalibrateSolve(CLI::App& calibrate, Invocation& invocation);
void AddCalibrateReport(CLI::App& calibrate, Invocation& invocation);
void AddGrayCodePatterns(CLI::App& calibrate, Invocation& invocation);
void AddGrayCode(CLI::App& calibrate, Invocation& invocation);
void AddWarp(CLI::App& calibrate, Invocation& invocation);

}  // namespace lamella
