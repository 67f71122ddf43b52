// What the stage depth leaves: depth/NAME.exr (float channels Z and confidence) and points.ply.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/depth_map.h"
#include "lightfield/image.h"

namespace lamella {

void SaveDepthMap(const std::filesystem::path& path, const DepthMap& map);
// InputError where the file is absent, damaged, or holds what no depth map can hold.
DepthMap LoadDepthMap(const std::filesystem::path& path);
// The depth alone, also of an EXR that has no confidence (true depth).
Image<float> LoadDepth(const std::filesystem::path& path);

struct ColoredPoint {
  Eigen::Vector3d position;  // world
  Rgb8 color;
};
// Binary little-endian PLY: double x y z, uchar red green blue. (World coordinates may lie far from
// the origin: floats would lose the scene there.)
void SavePoints(const std::filesystem::path& path, const std::vector<ColoredPoint>& points);

}  // namespace lamella
