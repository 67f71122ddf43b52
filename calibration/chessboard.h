// Plain chessboards, as cameras are calibrated with.
#pragma once

#include <optional>
#include <vector>

#include "calibration/saddle.h"
#include "lightfield/image.h"

namespace lamella {

// The inner corners of a chessboard of (columns + 1) x (rows + 1) squares that is seen whole, row
// by row: the order in which columns run to the right and rows down as the photograph shows them,
// up to a turn by 180 degrees of boards that look alike both ways. Refined within `half_window` px;
// 0: two fifths of the squares, at most 9. Nothing where no such board is found. `grey` holds
// numbers from 0 to 1 of any response.
std::optional<std::vector<Saddle>> FindChessboard(ImageSpan<const float> grey, int columns,
                                                  int rows, int half_window = 0);

}  // namespace lamella
