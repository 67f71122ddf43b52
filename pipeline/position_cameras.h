// Where the camera stood at each position of a calibration whose patterns do not tell it: by a file
// of the user's.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "lightfield/view.h"
#include "pipeline/check_photos.h"

namespace lamella {

// By position, from a transforms.json: a frame is a position's where its name, or its file's
// without the ending, is that of one of its photographs. UsageError where no file is named,
// InputError where a frame's camera has not the size of its photographs.
std::map<int, View> CamerasOfPositions(const CheckedPhotos& checked,
                                       const std::filesystem::path& file);
// InputError where there is none.
const View& CameraOfPosition(const std::map<int, View>& cameras, int position,
                             const CheckedPhotos& checked, const std::filesystem::path& file);

// Sinusoids are told by their place in the list: a photograph too few or too many makes others of
// those after it. Whether a position has every shot, good, and nothing else.
bool IsComplete(const CheckedPhotos& checked, int position);
std::string IncompletePosition(int position);  // what is told of one that is left out

}  // namespace lamella
