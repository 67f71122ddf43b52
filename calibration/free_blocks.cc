#include <memory>

#include <ceres/crs_matrix.h>
#include <ceres/manifold.h>

#include "calibration/free_blocks-inl.h"

namespace lamella {

std::vector<int> ColumnRange(int first, int num) {
  std::vector<int> columns;
  for (int i = 0; i < num; ++i) columns.push_back(first < 0 ? -1 : first + i);
  return columns;
}

void FreeBlocks::AddNumbers(double* values, const std::vector<int>& columns) {
  const int size = static_cast<int>(columns.size());
  std::vector<int> constant, free;
  for (int i = 0; i < size; ++i) {
    const int column = columns[static_cast<std::size_t>(i)];
    if (column < 0) {
      constant.push_back(i);
    } else {
      free.push_back(column);
    }
  }
  problem_.AddParameterBlock(values, size);
  if (free.empty()) return problem_.SetParameterBlockConstant(values);
  if (!constant.empty()) {
    problem_.SetManifold(values, std::make_unique<ceres::SubsetManifold>(size, constant).release());
  }
  free_.push_back({values, free, 1});
}

void FreeBlocks::AddRotation(double* xyzw, int first_column) {
  problem_.AddParameterBlock(xyzw, 4, std::make_unique<ceres::EigenQuaternionManifold>().release());
  if (first_column < 0) return problem_.SetParameterBlockConstant(xyzw);
  // A step in a quaternion's tangent space is half of the angle.
  free_.push_back({xyzw, ColumnRange(first_column, 3), 2});
}

void FreeBlocks::HoldBefore(int column) {
  for (const FreeBlock& block : free_) {
    if (block.columns.front() < column) problem_.SetParameterBlockConstant(block.values);
  }
}

NormalEquations FreeBlocks::Equations(int num_columns) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  std::vector<int> columns;
  std::vector<double> scales;
  for (const FreeBlock& block : free_) {
    options.parameter_blocks.push_back(block.values);
    columns.insert(columns.end(), block.columns.begin(), block.columns.end());
    scales.insert(scales.end(), block.columns.size(), 1 / block.column_per_tangent);
  }
  double half_cost = 0;
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
  problem_.Evaluate(options, &half_cost, &residuals, nullptr, &jacobian);
  NormalEquations equations;
  equations.cost = 2 * half_cost;
  equations.hessian.setZero(num_columns, num_columns);
  equations.gradient.setZero(num_columns);
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const int begin = jacobian.rows[at(row)], end = jacobian.rows[at(row + 1)];
    for (int i = begin; i < end; ++i) jacobian.values[at(i)] *= scales[at(jacobian.cols[at(i)])];
    for (int i = begin; i < end; ++i) {
      const double slope = jacobian.values[at(i)];
      const int column = columns[at(jacobian.cols[at(i)])];
      equations.gradient(column) += slope * residuals[at(row)];
      for (int j = begin; j < end; ++j) {
        equations.hessian(columns[at(jacobian.cols[at(j)])], column) +=
            slope * jacobian.values[at(j)];
      }
    }
  }
  return equations;
}

}  // namespace lamella
