// Pictures as textures, averaged so that nothing aliases.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

// Level 0 is the picture, each further level the mean over boxes with half as many texels a side
// (rounded up), the last one is 1 x 1. Linear light.
struct ImagePyramid {
  std::vector<Image<Rgb>> levels;
};

// Over (u, v) in [0, 1]^2: u right, v up, the picture upright.
struct ImageTexture {
  std::shared_ptr<const ImagePyramid> pyramid;  // never null, at least one level
  bool repeat = true;                           // beyond [0, 1]; else the rim goes on
};

ImageTexture MakeImageTexture(Image<Rgb> picture, bool repeat = true);
// InputError where the file is no picture (lightfield/image_io.h).
ImageTexture ReadImageTexture(const std::filesystem::path& path);

// The mean about (u, v) over a patch that measures footprint.x() in u and footprint.y() in v:
// trilinear, from levels whose texels are at least as large as the patch.
Rgb ColorAt(const ImageTexture& texture, const Eigen::Vector2d& uv,
            const Eigen::Vector2d& footprint);

}  // namespace lamella
