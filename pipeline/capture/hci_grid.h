// Camera grids of the HCI 4D light field benchmark: a folder with parameters.cfg and
// input_Cam000.png .. in row-major order, row 0 on top, column 0 left.
#pragma once

#include <filesystem>
#include <vector>

#include "lightfield/image.h"
#include "lightfield/view.h"

namespace lamella {

bool IsHciGrid(const std::filesystem::path& folder);

// Every view of the grid, images present or not, sorted by name. World: the axes of the cameras
// (x right, y down, z forward), metres, the origin at the grid's centre; the scene's own placement
// (center_cam_*) is not used. The view in the centre has the true disparity as its depth where the
// grid comes with it (gt_disp_lowres.pfm). InputError where parameters.cfg is broken or no image is
// there.
std::vector<View> ReadHciGrid(const std::filesystem::path& folder);

bool IsHciDisparity(const std::filesystem::path& path);

// Depth in metres from a grid's true disparity, of the views' size; +inf at infinity and beyond, 0
// where the disparity is no finite number. InputError where the file has another size, cannot be
// read, or parameters.cfg beside it is broken.
Image<float> ReadHciDepth(const std::filesystem::path& disparity);

}  // namespace lamella
