// Points of a plane by the cell that they lie in, so that those near a place are found without
// asking all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace lamella {

class PlaceGrid {
 public:
  // `radius` is above 0; points beyond 2^31 of it from the origin are in its outermost cells.
  PlaceGrid(std::vector<Eigen::Vector2d> places, double radius);
  // The numbers of the places no farther than the radius from one, rising.
  std::vector<std::size_t> Within(const Eigen::Vector2d& at) const;

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  Cell CellOf(const Eigen::Vector2d& at) const;

  std::vector<Eigen::Vector2d> places_;
  double radius_;
  std::map<Cell, std::vector<std::size_t>> cells_;  // as wide as the radius
};

}  // namespace lamella
