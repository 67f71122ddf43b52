#include "calibration/place_grid.h"

#include <algorithm>
#include <cmath>

namespace lamella {

PlaceGrid::PlaceGrid(std::vector<Eigen::Vector2d> places, double radius)
    : places_(std::move(places)), radius_(radius) {
  for (std::size_t i = 0; i < places_.size(); ++i) cells_[CellOf(places_[i])].push_back(i);
}

PlaceGrid::Cell PlaceGrid::CellOf(const Eigen::Vector2d& at) const {
  constexpr double kMost = 2147483648;
  const auto cell = [&](double x) {
    return static_cast<std::int64_t>(std::clamp(std::floor(x / radius_), -kMost, kMost));
  };
  return {cell(at.x()), cell(at.y())};
}

std::vector<std::size_t> PlaceGrid::Within(const Eigen::Vector2d& at) const {
  const Cell middle = CellOf(at);
  std::vector<std::size_t> near;
  for (std::int64_t x = middle.first - 1; x <= middle.first + 1; ++x) {
    for (std::int64_t y = middle.second - 1; y <= middle.second + 1; ++y) {
      const auto cell = cells_.find({x, y});
      if (cell == cells_.end()) continue;
      for (const std::size_t i : cell->second) {
        if ((places_[i] - at).squaredNorm() <= radius_ * radius_) near.push_back(i);
      }
    }
  }
  std::sort(near.begin(), near.end());
  return near;
}

}  // namespace lamella
