// Which columns of the unknowns Ceres' parameter blocks are, and normal equations in these columns.
// Include it in .cc files only, as all of Ceres.
#pragma once

#include <vector>

#include <ceres/problem.h>

#include "calibration/residuals.h"

namespace lamella {

// `num` columns from the first; all -1, constant, where that is.
std::vector<int> ColumnRange(int first, int num);

class FreeBlocks {
 public:
  explicit FreeBlocks(ceres::Problem& problem) : problem_(problem) {}

  // A block of numbers with the column of each, -1: constant.
  void AddNumbers(double* values, const std::vector<int>& columns);
  // A rotation with 3 columns (radians about the axes that it turns into), -1: constant.
  void AddRotation(double* xyzw, int first_column);
  // Keeps the blocks that begin before a column as they are.
  void HoldBefore(int column);
  // At the blocks' values, of `num_columns`. For a problem without a loss.
  NormalEquations Equations(int num_columns);

 private:
  // A block with the columns of its tangent space and how far one unit of it goes in a column.
  struct FreeBlock {
    double* values;
    std::vector<int> columns;
    double column_per_tangent;
  };

  ceres::Problem& problem_;
  std::vector<FreeBlock> free_;
};

}  // namespace lamella
