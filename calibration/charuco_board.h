// ChArUco boards (OpenCV's, of its dictionary DICT_5X5_1000) that fill a panel or a sheet of paper:
// a chessboard whose white squares hold markers, so that every corner has an identity
// (calibration.md sections 3 and 4).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "lightfield/calibration.h"
#include "lightfield/image.h"

namespace lamella {

// Pixels are those of the panel, edges at whole numbers, v down. The first square, top left, is
// black. Corner i + j (columns - 1) lies at (left + (i + 1) square, top + (j + 1) square).
struct CharucoBoard {
  int panel_width_px = 0, panel_height_px = 0;
  int columns = 0, rows = 0;  // squares; an odd number of rows
  int square_px = 0;          // a multiple of 5, so that markers of 0.6 squares are whole
  int left_px = 0, top_px = 0;
  int first_id = 0;  // of its markers

  int marker_px() const { return square_px * 3 / 5; }
  int num_markers() const { return columns * rows / 2; }
  int num_corners() const { return (columns - 1) * (rows - 1); }
  Eigen::Vector2d CornerPx(int corner) const;
  friend bool operator==(const CharucoBoard&, const CharucoBoard&) = default;
};

struct PanelSize {
  int width_px = 0, height_px = 0;
};
// 4 x 3 squares of 40 px, of whose markers a module has 3 px or more.
bool HasRoomForBoard(const PanelSize& panel);

// Boards of about 24 x 13 squares whose markers' identities are distinct over all panels; of fewer
// and larger squares where the dictionary's 1000 would not suffice. UsageError where a panel is too
// small, or there are too many panels.
std::vector<CharucoBoard> LayOutBoards(const std::vector<PanelSize>& panels);

// A board on paper, fixed to a display's frame, where lenses hide what would tell the camera's
// place (calibration.md section 3). Its frame is a panel's: mm, origin in the middle, x right, y
// up, z towards the viewer.
struct PrintedBoard {
  CharucoBoard board;
  double square_mm = 0;  // side of a square
  double pitch_mm() const { return square_mm / board.square_px; }
  friend bool operator==(const PrintedBoard&, const PrintedBoard&) = default;
};
// The board as a panel whose pixels are those of its drawing.
PanelCalibration PanelOf(const PrintedBoard& printed);
// 13 x 9 squares of 20 mm, which fill a sheet of A4 across, of the dictionary's last markers.
PrintedBoard BoardToPrint();

// What the panel shows: white around the board, every square whole pixels.
Image<Rgb8> DrawBoard(const CharucoBoard& board);

}  // namespace lamella
