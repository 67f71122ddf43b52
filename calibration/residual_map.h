// Where on its panels a calibration fits: residuals by the panel's cells, which random errors leave
// at zero and a bow, a wrong index or a wrong plate do not. calibration.md section 7.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "calibration/solve.h"
#include "lightfield/calibration.h"

namespace lamella {

// Seen minus predicted, in the panel's pixels, so that photographs taken from all sides and turned
// cameras add up.
struct ResidualCell {
  int num_points = 0;
  Eigen::Vector2d mean_px{0, 0};
  double rms_px = 0;     // of the length
  int num_left_out = 0;  // points that disagree, of photographs that else do not
  // What chance does to the mean at most, errors being independent: four standard deviations.
  double ChancePx() const;
};
inline constexpr double kLargestMeanPx = 0.03;  // that a cell may be off, beside chance

struct ResidualMap {
  static constexpr int kColumns = 8, kRows = 5;
  static constexpr std::size_t kCells = 40;
  PanelId panel;
  std::vector<int> views;           // that show it with points that count, sorted
  std::vector<ResidualCell> cells;  // row by row from the panel's top left
  const ResidualCell& At(int column, int row) const {
    return cells[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
  }
  std::size_t CellsSeen() const;  // with points that count
};

// What one photograph says of a panel: points, their whitened residuals L^T (predicted - seen) with
// L L^T the inverse of their covariance, and which of them count.
struct PanelResiduals {
  int view = 0;
  const std::vector<Observation>* points = nullptr;
  const Eigen::Matrix2Xd* whitened = nullptr;
  const std::vector<char>* inlier = nullptr;
};
// Of the photographs with points that count; all must outlive the call.
ResidualMap MapOf(const PanelId& id, const PanelCalibration& panel,
                  const std::vector<PanelResiduals>& photos);
// Of several panels together: its means are those of all points.
ResidualMap Pooled(const std::vector<ResidualMap>& maps);

// One per photographed panel, of the points that count.
std::vector<ResidualMap> MapResiduals(const Fit& fit, const Structure& structure,
                                      const Observations& observations);

}  // namespace lamella
