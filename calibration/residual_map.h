// Where on its panels a calibration fits: residuals by the panel's cells, which random errors leave
// at zero and a bow, a wrong index or a wrong plate do not. calibration.md section 7.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "calibration/solve.h"

namespace lamella {

// Seen minus predicted, in the panel's pixels, so that photographs taken from all sides and turned
// cameras add up.
struct ResidualCell {
  int num_points = 0;
  Eigen::Vector2d mean_px{0, 0};
  double rms_px = 0;     // of the length
  int num_left_out = 0;  // points that disagree, of photographs that else do not
};

struct ResidualMap {
  static constexpr int kColumns = 8, kRows = 5;
  static constexpr std::size_t kCells = 40;
  PanelId panel;
  std::vector<int> views;           // that show it with points that count, sorted
  std::vector<ResidualCell> cells;  // row by row from the panel's top left
  const ResidualCell& At(int column, int row) const {
    return cells[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
  }
};

// One per photographed panel, of the points that count.
std::vector<ResidualMap> MapResiduals(const Fit& fit, const Structure& structure,
                                      const Observations& observations);

}  // namespace lamella
