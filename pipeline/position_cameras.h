// Where the camera stood at each position of a calibration whose panels do not tell it: by a file
// of the user's, or by a printed board.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calibration/board_cameras.h"
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

// The printed board with its squares as they were measured (0: as drawn). UsageError where the
// patterns have none.
PrintedBoard BoardOf(const CheckedPhotos& checked, double square_mm);
// The corners of the board at every position where it is seen well enough, also where nothing else
// was photographed. InputError where photographs differ in size or the board is in none.
std::vector<BoardPhoto> BoardPhotosOf(const CheckedPhotos& checked,
                                      const std::filesystem::path& photos);
// The one camera of all photographs; focal_px 0: found.
PhotoCamera BodyOf(const CheckedPhotos& checked, double focal_px);

// Sinusoids are told by their place in the list: a photograph too few or too many makes others of
// those after it. Whether a position has every shot of the display, good, and nothing else but the
// printed board's.
bool IsComplete(const CheckedPhotos& checked, int position);
// A line for each position that is neither complete nor of the printed board alone.
std::vector<std::string> IncompletePositions(const CheckedPhotos& checked);
// And for each that is complete and none of `positions` (rising), from which the board is seen.
std::vector<std::string> PositionsWithoutBoard(const CheckedPhotos& checked,
                                               const std::vector<int>& positions);

}  // namespace lamella
