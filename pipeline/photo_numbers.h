// Photographs as one number a pixel.
#pragma once

#include <filesystem>
#include <string>

#include "lightfield/image.h"

namespace lamella {

// A photograph's luminance, linear in light: blur then leaves a marker's black border as wide as it
// is, where in sRGB's numbers white grows into it.
Image<float> ReadLuminance(const std::filesystem::path& file);
// The mean of its three channels, linear in light: to it a lens that magnifies one sub-pixel is as
// bright as its neighbour with another, where luminance would see the green ones only.
Image<float> ReadMeanLight(const std::filesystem::path& file);
// The same of its numbers as they are.
Image<float> ReadMeanNumbers(const std::filesystem::path& file);

struct PhotoSize {
  std::string photo;  // its name, or file
  int width = 0, height = 0;
};
// InputError naming both where they differ.
void CheckSameSize(const PhotoSize& photo, const PhotoSize& first);

}  // namespace lamella
