// Known cameras, whatever the format they come in.
#pragma once

#include <filesystem>
#include <vector>

#include "lightfield/view.h"

namespace lamella {

// The cameras of a transforms.json (or of a folder with one), of a folder of Strecha `.camera`
// files, of an HCI grid's folder, or of a COLMAP model's folder; sorted by name. View::image is the
// photograph where the format tells it (it need not exist), else empty. InputError where the path
// holds none of these, a file is broken, or two cameras have one name.
std::vector<View> ReadKnownCameras(const std::filesystem::path& file_or_folder);

}  // namespace lamella
