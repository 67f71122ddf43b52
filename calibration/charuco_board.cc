#include "calibration/charuco_board.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/aruco_markers.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr int kSquareStep = 5, kLeastSquare = 40;
constexpr int kLeastColumns = 4, kLeastRows = 3;
// 24 x 13.5 squares on 1920 x 1080 px.
constexpr double kSquares = 24 * 13.5;

CharucoBoard LayOut(const PanelSize& panel, int square_px) {
  CharucoBoard board{panel.width_px, panel.height_px, panel.width_px / square_px,
                     panel.height_px / square_px, square_px};
  if (board.rows % 2 == 0) board.rows -= 1;
  board.left_px = (panel.width_px - board.columns * square_px) / 2;
  board.top_px = (panel.height_px - board.rows * square_px) / 2;
  return board;
}

// `coarseness` 0 is the finest board.
CharucoBoard LayOutCoarse(const PanelSize& panel, int coarseness) {
  const double side = std::sqrt(static_cast<double>(panel.width_px) * panel.height_px / kSquares);
  const int square = std::max(kLeastSquare, static_cast<int>(side) / kSquareStep * kSquareStep);
  return LayOut(panel, square + coarseness * kSquareStep);
}

}  // namespace

bool HasRoomForBoard(const PanelSize& panel) {
  return panel.width_px >= kLeastColumns * kLeastSquare &&
         panel.height_px >= kLeastRows * kLeastSquare;
}

Eigen::Vector2d CharucoBoard::CornerPx(int corner) const {
  const int i = corner % (columns - 1), j = corner / (columns - 1);
  return {left_px + (i + 1) * square_px, top_px + (j + 1) * square_px};
}

std::vector<CharucoBoard> LayOutBoards(const std::vector<PanelSize>& panels) {
  for (int coarseness = 0;; ++coarseness) {
    std::vector<CharucoBoard> boards;
    int next_id = 0;
    for (const PanelSize& panel : panels) {
      boards.push_back(LayOutCoarse(panel, coarseness));
      CharucoBoard& board = boards.back();
      if (board.columns < kLeastColumns || board.rows < kLeastRows) {
        throw UsageError(fmt::format("a panel of {} x {} px", panel.width_px, panel.height_px),
                         coarseness == 0
                             ? "is too small for a board of markers"
                             : fmt::format("is one of {} panels, too many for one set of markers",
                                           panels.size()),
                         "use --mode precise, whose sinusoids need no markers");
      }
      board.first_id = next_id;
      next_id += board.num_markers();
    }
    if (next_id <= kNumMarkers) return boards;
  }
}

PrintedBoard BoardToPrint() {
  constexpr int kColumns = 13, kRows = 9;
  constexpr int kSquarePx = 35;  // a marker's module is 3 px
  constexpr double kSquareMm = 20, kPaperWidthMm = 297, kPaperHeightMm = 210;
  const auto pixels = [](double mm) { return static_cast<int>(mm / kSquareMm * kSquarePx); };
  CharucoBoard board{pixels(kPaperWidthMm), pixels(kPaperHeightMm), kColumns, kRows, kSquarePx};
  board.left_px = (board.panel_width_px - kColumns * kSquarePx) / 2;
  board.top_px = (board.panel_height_px - kRows * kSquarePx) / 2;
  board.first_id = kNumMarkers - board.num_markers();
  return {board, kSquareMm};
}

PanelCalibration PanelOf(const PrintedBoard& printed) {
  PanelCalibration panel;
  panel.width_px = printed.board.panel_width_px;
  panel.height_px = printed.board.panel_height_px;
  panel.pitch_mm = printed.pitch_mm();
  return panel;
}

Image<Rgb8> DrawBoard(const CharucoBoard& board) {
  Image<Rgb8> image(board.panel_width_px, board.panel_height_px, {255, 255, 255});
  const Image<std::uint8_t> squares =
      DrawCharuco(board.columns, board.rows, board.square_px, board.marker_px(), board.first_id);
  for (int v = 0; v < squares.height(); ++v) {
    Rgb8* row = image.row(board.top_px + v) + board.left_px;
    for (int u = 0; u < squares.width(); ++u) {
      row[u] = {squares(u, v), squares(u, v), squares(u, v)};
    }
  }
  return image;
}

}  // namespace lamella
