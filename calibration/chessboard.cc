#include "calibration/chessboard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <map>
#include <utility>

#include "calibration/dark_regions.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr int kLeastSidePx = 4;
constexpr int kMostErosion = 3;
constexpr double kMostGap = 0.5;  // sides, between corners of two squares that meet there
constexpr int kMostHalfWindow = 9, kLeastHalfWindow = 3;

struct Corner {
  std::size_t square = 0, index = 0;
  friend bool operator==(const Corner&, const Corner&) = default;
};

// Dark squares stand alone once a pixel is taken off around them.
Image<std::uint8_t> Thinned(const Image<std::uint8_t>& dark) {
  Image<std::uint8_t> thin(dark.width(), dark.height());
  for (int y = 1; y + 1 < dark.height(); ++y) {
    for (int x = 1; x + 1 < dark.width(); ++x) {
      thin(x, y) = dark(x, y) & dark(x - 1, y) & dark(x + 1, y) & dark(x, y - 1) & dark(x, y + 1);
    }
  }
  return thin;
}

double SideOf(const Quad& quad) {
  double sum = 0;
  for (std::size_t s = 0; s < 4; ++s) sum += (quad[(s + 1) % 4] - quad[s]).norm() / 4;
  return sum;
}

std::vector<Quad> SquaresOf(const Image<std::uint8_t>& dark) {
  constexpr double kMostRatio = 10;  // boards may end in half squares
  std::vector<Quad> squares;
  for (const Region& region : ConnectedRegions(dark, kLeastSidePx)) {
    const auto quad = FitQuad(region);
    if (!quad) continue;
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t s = 0; s < 4; ++s) {
      const double side = ((*quad)[(s + 1) % 4] - (*quad)[s]).norm();
      least = std::min(least, side);
      most = std::max(most, side);
    }
    if (most < kMostRatio * least) squares.push_back(*quad);
  }
  return squares;
}

// For every corner the nearest corner of another square, where that is near.
std::map<std::pair<std::size_t, std::size_t>, Corner> NearestCorners(
    const std::vector<Quad>& squares) {
  std::map<std::pair<std::size_t, std::size_t>, Corner> nearest;
  for (std::size_t a = 0; a < squares.size(); ++a) {
    for (std::size_t i = 0; i < 4; ++i) {
      double least = kMostGap * SideOf(squares[a]);
      for (std::size_t b = 0; b < squares.size(); ++b) {
        if (a == b) continue;
        for (std::size_t j = 0; j < 4; ++j) {
          const double distance = (squares[a][i] - squares[b][j]).norm();
          if (distance >= least) continue;
          least = distance;
          nearest[{a, i}] = {b, j};
        }
      }
    }
  }
  return nearest;
}

// Where a square stands in the grid of corners: its corner 0, and the step from there to corner 1;
// further corners follow clockwise.
struct Placing {
  Vector2i corner0, step0;
  static Vector2i Turned(Vector2i step, std::size_t times) {
    for (std::size_t i = 0; i < times; ++i) step = Vector2i(-step.y(), step.x());
    return step;
  }
  Vector2i StepFrom(std::size_t corner) const { return Turned(step0, corner); }
  Vector2i At(std::size_t corner) const {
    Vector2i at = corner0;
    for (std::size_t i = 0; i < corner; ++i) at += StepFrom(i);
    return at;
  }
};

struct Less {
  bool operator()(const Vector2i& a, const Vector2i& b) const {
    return std::pair(a.y(), a.x()) < std::pair(b.y(), b.x());
  }
};
using Grid = std::map<Vector2i, Vector2d, Less>;  // corner of the grid -> about where it is seen

// Of all squares that hang together with one: two dark squares that meet at a corner are each
// other's image by a half turn about it.
Grid GrowFrom(std::size_t first, const std::vector<Quad>& squares,
              const std::map<std::pair<std::size_t, std::size_t>, Corner>& nearest,
              std::vector<char>& used) {
  Grid grid;
  std::map<std::size_t, Placing> placings = {{first, {{0, 0}, {1, 0}}}};
  std::deque<std::size_t> queue = {first};
  used[first] = 1;
  while (!queue.empty()) {
    const std::size_t a = queue.front();
    queue.pop_front();
    const Placing placing = placings.at(a);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto link = nearest.find({a, i});
      if (link == nearest.end()) continue;
      const Corner other = link->second;
      const auto back = nearest.find({other.square, other.index});
      if (back == nearest.end() || !(back->second == Corner{a, i})) continue;
      grid[placing.At(i)] = (squares[a][i] + squares[other.square][other.index]) / 2;
      if (used[other.square]) continue;
      used[other.square] = 1;
      Placing next{{0, 0}, Placing::Turned(-placing.StepFrom(i), (4 - other.index) % 4)};
      next.corner0 = placing.At(i) - next.At(other.index);
      placings[other.square] = next;
      queue.push_back(other.square);
    }
  }
  return grid;
}

// About where a corner is that was not seen: from two beside it in its row or column, or further
// along them.
std::optional<Vector2d> Predicted(const Grid& grid, const Vector2i& at) {
  Vector2d sum(0, 0);
  int count = 0;
  const auto add = [&](const Vector2i& a, double weight_a, const Vector2i& b, double weight_b) {
    const auto first = grid.find(at + a), second = grid.find(at + b);
    if (first == grid.end() || second == grid.end()) return;
    sum += weight_a * first->second + weight_b * second->second;
    ++count;
  };
  for (const Vector2i& step : {Vector2i(1, 0), Vector2i(0, 1)}) add(step, 0.5, -step, 0.5);
  if (count == 0) {
    for (const Vector2i& step :
         {Vector2i(1, 0), Vector2i(-1, 0), Vector2i(0, 1), Vector2i(0, -1)}) {
      add(step, 2, 2 * step, -1);
    }
  }
  return count > 0 ? std::optional<Vector2d>(sum / count) : std::nullopt;
}

// A few squares may not have been found; their corners are refined, and so confirmed, like all.
void FillGaps(Grid& grid, const Vector2i& low, const Vector2i& high) {
  const Grid seen = grid;
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      if (seen.contains({x, y})) continue;
      if (const auto place = Predicted(seen, {x, y})) grid[{x, y}] = *place;
    }
  }
}

// The grid's corners row by row, if it is of columns x rows corners.
std::optional<std::vector<Vector2d>> InOrder(Grid grid, int columns, int rows) {
  constexpr double kLeastSeen = 0.9;
  if (static_cast<double>(grid.size()) < kLeastSeen * columns * rows) return std::nullopt;
  Vector2i low = grid.begin()->first, high = low;
  for (const auto& [at, place] : grid) {
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Vector2i size = high - low + Vector2i(1, 1);
  if (size.prod() != columns * rows) return std::nullopt;
  FillGaps(grid, low, high);
  // Quarter turns of the grid, which keep its handedness.
  for (const bool turned : {false, true}) {
    if (size != (turned ? Vector2i(rows, columns) : Vector2i(columns, rows))) continue;
    std::vector<Vector2d> corners;
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const auto found = grid.find(low + (turned ? Vector2i(rows - 1 - j, i) : Vector2i(i, j)));
        if (found == grid.end()) return std::nullopt;
        corners.push_back(found->second);
      }
    }
    const Vector2d along = corners[static_cast<std::size_t>(columns) - 1] - corners.front();
    if (along.x() < 0) std::reverse(corners.begin(), corners.end());
    return corners;
  }
  return std::nullopt;
}

Vector2d MiddleOf(const Quad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) / 4; }

// Those that are not there yet: large squares come apart late, small ones have vanished by then.
// What has come apart into two is taken out.
void AddNew(std::vector<Quad>& squares, const std::vector<Quad>& more) {
  std::erase_if(squares, [&](const Quad& old) {
    return std::count_if(more.begin(), more.end(), [&](const Quad& quad) {
             return (MiddleOf(old) - MiddleOf(quad)).norm() < SideOf(old);
           }) > 1;
  });
  const std::size_t known = squares.size();
  for (const Quad& quad : more) {
    const bool is_new =
        std::all_of(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(known),
                    [&](const Quad& other) {
                      return (MiddleOf(other) - MiddleOf(quad)).norm() > SideOf(quad) / 3;
                    });
    if (is_new) squares.push_back(quad);
  }
}

std::optional<std::vector<Vector2d>> RoughCorners(const std::vector<Quad>& squares, int columns,
                                                  int rows) {
  const auto nearest = NearestCorners(squares);
  std::vector<char> used(squares.size(), 0);
  for (std::size_t first = 0; first < squares.size(); ++first) {
    if (used[first]) continue;
    auto corners = InOrder(GrowFrom(first, squares, nearest, used), columns, rows);
    if (corners) return corners;
  }
  return std::nullopt;
}

// Half the distance to the nearest other corner of its row or column, times 0.8.
int HalfWindow(const std::vector<Vector2d>& corners, int columns, std::size_t corner) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::size_t step : {std::size_t{1}, static_cast<std::size_t>(columns)}) {
    if (corner >= step)
      nearest = std::min(nearest, (corners[corner] - corners[corner - step]).norm());
    if (corner + step < corners.size()) {
      nearest = std::min(nearest, (corners[corner] - corners[corner + step]).norm());
    }
  }
  return std::clamp(static_cast<int>(0.4 * nearest), kLeastHalfWindow, kMostHalfWindow);
}

}  // namespace

std::optional<std::vector<Saddle>> FindChessboard(ImageSpan<const float> grey, int columns,
                                                  int rows, int half_window) {
  constexpr float kLeastContrast = 0.1F;
  const double noise = EstimateNoise(grey);
  Image<std::uint8_t> dark = DarkPixels(grey, kLeastContrast);
  std::vector<Quad> squares;
  for (int erosion = 0; erosion <= kMostErosion; ++erosion) {
    if (erosion > 0) dark = Thinned(dark);
    AddNew(squares, SquaresOf(dark));
    const auto rough = RoughCorners(squares, columns, rows);
    if (!rough) continue;
    std::vector<Saddle> corners;
    for (std::size_t i = 0; i < rough->size(); ++i) {
      const int window = half_window > 0 ? half_window : HalfWindow(*rough, columns, i);
      const auto corner = RefineSaddle(grey, (*rough)[i], window, noise);
      if (!corner) break;
      corners.push_back(*corner);
    }
    if (corners.size() == rough->size()) return corners;
  }
  return std::nullopt;
}

}  // namespace lamella
