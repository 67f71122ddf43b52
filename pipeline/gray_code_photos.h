// Gray-code patterns as files, and what a folder of photographs of them says.
#pragma once

#include <cstdint>
#include <filesystem>

#include "calibration/gray_code.h"
#include "lightfield/progress.h"

namespace lamella {

// One PNG per pattern, whose names sort in the patterns' order.
void WriteGrayCode(const std::filesystem::path& folder, const GrayCodePatterns& patterns,
                   Progress& progress);

// The folder's images by their names, numbers in these by their value, in the patterns' order; the
// mean of the files' three channels, no curve taken off. InputError where there are more or fewer
// than patterns, they differ in size, no pixel is valid, or a third of the steps from cell to cell
// go back (ShareOfStepsBack).
ScreenMap ReadGrayCode(const std::filesystem::path& photos, const GrayCodePatterns& patterns,
                       double least_contrast, Progress& progress);

// docs/formats.md, "Gray code".
void SaveScreenMap(const std::filesystem::path& file, const ScreenMap& map);

// What the valid pixels see, px of the screen.
struct SeenOfScreen {
  std::int64_t num_valid = 0;
  float first_u = 0, last_u = 0, first_v = 0, last_v = 0;
};
SeenOfScreen SeenOf(const ScreenMap& map);

}  // namespace lamella
