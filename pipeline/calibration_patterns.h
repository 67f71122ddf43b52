// The patterns of a calibration as files: what to show, and what `calibrate check` reads again.
#pragma once

#include <filesystem>

#include "calibration/shot_list.h"
#include "lightfield/progress.h"

namespace lamella {

// The display as designed, beside its patterns: `calibrate patterns` puts it there.
inline constexpr const char* kPatternsDisplay = "display.toml";

// Writes into the folder: the patterns' PNG files, a printed board as PDF and PNG, shots.json (as
// `synth photos` reads it), patterns.json (docs/formats.md) and shots.txt, for the person at the
// camera.
void WritePatterns(const std::filesystem::path& folder, const ShotList& list, Progress& progress);

// InputError where patterns.json is absent or does not say what is needed.
ShotList LoadShotList(const std::filesystem::path& folder);

}  // namespace lamella
