// Strecha's `.camera` files (Benchmarking Camera Calibration, CVPR 2008): one per photograph,
// named NAME.EXT.camera.
#pragma once

#include <filesystem>
#include <vector>

#include "lightfield/view.h"

namespace lamella {

// True where the folder holds `.camera` files.
bool IsStrechaFolder(const std::filesystem::path& folder);

// The cameras of a folder, sorted by name. InputError where a file is broken.
std::vector<View> ReadStrechaFolder(const std::filesystem::path& folder);
View ReadStrechaCamera(const std::filesystem::path& file);

}  // namespace lamella
