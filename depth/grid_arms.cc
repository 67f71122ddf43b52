#include "depth/grid_arms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lamella {
namespace {

constexpr int kSides = 8;
constexpr int kEnoughOnTheCross = 8;

struct Offset {
  int columns, rows;
  int Steps() const { return std::max(std::abs(columns), std::abs(rows)); }
  int Squared() const { return columns * columns + rows * rows; }
  bool OnTheCross() const { return columns == 0 || rows == 0; }
  // The nearest of the directions, from the left upwards around.
  int Side(int sides) const {
    const double turn = std::atan2(static_cast<double>(-rows), static_cast<double>(-columns)) /
                        (2 * std::numbers::pi);
    return (static_cast<int>(std::lround(turn * sides)) + sides) % sides;
  }
};

Offset OffsetOf(const View& view, const View& reference) {
  return {view.grid->column - reference.grid->column, view.grid->row - reference.grid->row};
}

// `count` of a sorted side, evenly over its distances and always with the farthest.
std::vector<int> Spread(const std::vector<int>& side, int count) {
  const int size = static_cast<int>(side.size());
  if (size <= count) return side;
  std::vector<int> chosen;
  for (int i = 1; i <= count; ++i)
    chosen.push_back(side[static_cast<std::size_t>(i * size / count - 1)]);
  return chosen;
}

}  // namespace

GridArms ChooseGridArms(const std::vector<View>& views, int reference, int reach, int per_arm) {
  const View& centre = views[static_cast<std::size_t>(reference)];
  const auto offset = [&](int v) { return OffsetOf(views[static_cast<std::size_t>(v)], centre); };
  std::vector<int> others;
  for (int v = 0; v < static_cast<int>(views.size()); ++v) {
    if (offset(v).Steps() > 0) others.push_back(v);
  }
  // By distance; ties in the order of the views.
  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return offset(a).Squared() < offset(b).Squared(); });
  int nearest = others.empty() ? 0 : offset(others.front()).Steps();
  for (const int v : others) nearest = std::min(nearest, offset(v).Steps());
  const int within = std::max(reach, nearest);
  std::erase_if(others, [&](int v) { return offset(v).Steps() > within; });
  const auto on_cross =
      std::count_if(others.begin(), others.end(), [&](int v) { return offset(v).OnTheCross(); });
  const bool cross = on_cross >= kEnoughOnTheCross;
  if (cross) std::erase_if(others, [&](int v) { return !offset(v).OnTheCross(); });
  const int sides = cross ? kSides / 2 : kSides;
  GridArms arms(static_cast<std::size_t>(sides));
  for (const int v : others) arms[static_cast<std::size_t>(offset(v).Side(sides))].push_back(v);
  for (std::vector<int>& arm : arms) arm = Spread(arm, per_arm);
  return arms;
}

int ReachOf(const std::vector<View>& views, int reference, const GridArms& arms) {
  int reach = 0;
  for (const std::vector<int>& arm : arms) {
    for (const int v : arm) {
      reach = std::max(reach, OffsetOf(views[static_cast<std::size_t>(v)],
                                       views[static_cast<std::size_t>(reference)])
                                  .Steps());
    }
  }
  return reach;
}

}  // namespace lamella
