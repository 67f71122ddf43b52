// The corners of a panel's board in a photograph (calibration.md section 4).
#pragma once

#include <optional>
#include <vector>

#include "calibration/charuco_board.h"
#include "calibration/observations.h"
#include "lightfield/image.h"

namespace lamella {

// The largest window that a corner is refined in reaches so far from it, px of the photograph.
inline constexpr int kMostHalfWindow = 13;

struct BoardSighting {
  std::size_t board = 0;  // in the list that was looked for
  bool mirrored = false;  // seen by reflection
  int num_markers = 0;
  double scale = 0;    // photograph's px per panel px: the median over the markers' sides
  double blur_px = 0;  // sigma of the edges; the median over the corners
  std::vector<Observation> points;  // by rising corner; pixels of the photograph as it was taken
};

// The one board of which, in one handedness, ten times as many markers are seen as of any other;
// nothing where there is none. OpenCV finds the first markers, in the photograph and in its mirror
// image; where corners beside these tell where others are, those are read there. Corners come from
// the homographies of the markers beside them and are refined as saddles, in windows that reach at
// most kMostHalfWindow and at most three quarters of the way to the nearest marker corner, and end
// 3 px before the border. `grey` holds numbers of any response; of linear light the smallest
// markers are read.
std::optional<BoardSighting> DetectBoard(ImageSpan<const float> grey,
                                         const std::vector<CharucoBoard>& boards);

}  // namespace lamella
