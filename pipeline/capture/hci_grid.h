// Camera grids of the HCI 4D light field benchmark: a folder with parameters.cfg and
// input_Cam000.png .. in row-major order, row 0 on top, column 0 left.
#pragma once

#include <filesystem>
#include <vector>

#include "lightfield/view.h"

namespace lamella {

bool IsHciGrid(const std::filesystem::path& folder);

// Every view of the grid, images present or not, sorted by name. World: the axes of the cameras
// (x right, y down, z forward), metres, the origin at the grid's centre; the scene's own placement
// (center_cam_*) is not used. InputError where parameters.cfg is broken or no image is there.
std::vector<View> ReadHciGrid(const std::filesystem::path& folder);

}  // namespace lamella
