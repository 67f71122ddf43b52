// The photographs of a capture as COLMAP takes them: under safe names, upright, 8 bits.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lightfield/progress.h"
#include "pipeline/capture_record.h"

namespace lamella {

// Makes a file in `folder` for every view: a link to the original where COLMAP reads that as we do
// (8-bit JPEG or PNG, upright), else a PNG of it. COLMAP's text formats break at blanks in names
// and it ignores EXIF orientation. Returns the files' names, one a view, in the order of the views.
std::vector<std::string> MakePhotoFolder(const CaptureRecord& capture,
                                         const std::filesystem::path& folder, Progress& progress);

}  // namespace lamella
