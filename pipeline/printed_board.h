// A board of markers as a page for the printer.
#pragma once

#include <string>

#include "calibration/charuco_board.h"

namespace lamella {

// A PDF page of the board's size: black rectangles, exact at any resolution, and a line that says
// how it is to be printed.
std::string PdfOf(const PrintedBoard& printed);

}  // namespace lamella
