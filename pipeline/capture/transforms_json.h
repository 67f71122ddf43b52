// transforms.json of nerfstudio and instant-ngp: camera-to-world poses in OpenGL axes (x right,
// y up, z back). The only place where those become ours and back.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lightfield/view.h"

namespace lamella {

struct TransformsJson {
  std::vector<View> views;        // in the file's order; images are absolute paths
  std::vector<std::string> lost;  // photographs without a pose; our own form only
};

// A file that ends in .json, or a folder with a transforms.json.
bool IsTransformsJson(const std::filesystem::path& path);

// InputError where the file or a frame can't be used. Sizes that the file does not tell are read
// from the images.
TransformsJson ReadTransformsJson(const std::filesystem::path& path);

// Our own form: format_version, per-frame intrinsics (k4 to k6 of a Brown camera have no name there
// and are left out), names and grid positions.
// Images below the file's folder are written relative to it, others with their absolute path.
void WriteTransformsJson(const std::filesystem::path& file, const TransformsJson& transforms);

}  // namespace lamella
