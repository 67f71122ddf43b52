// What a capture's input is, and the views that it lists.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/capture_record.h"
#include "pipeline/stages.h"

namespace lamella {

// The views that `options` choose, by name: names, files, known cameras, poses and grid positions;
// no image is opened. InputError where the input is nothing that is known here, holds no image or
// two views of one name; UsageError where a pattern of `options.views` meets none.
std::vector<CapturedView> ListViews(const CaptureOptions& options);

// The files beside the images that ListViews reads, sorted.
std::vector<std::filesystem::path> CameraFiles(const CaptureOptions& options);

// True where structure from motion or triangulation will be needed: for all but regular grids.
bool NeedsColmap(const CaptureOptions& options);

}  // namespace lamella
