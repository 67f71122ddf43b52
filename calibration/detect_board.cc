#include "calibration/detect_board.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "calibration/find_markers.h"
#include "calibration/saddle.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kMostHalfWindow = 9, kLeastHalfWindow = 4, kMarkerMargin = 2;
constexpr double kRatio = 10;  // of markers, between the board and anything else
constexpr int kLeastMarkers = 4;
constexpr double kMostOff = 0.3;    // squares, of a neighbouring marker from where it should be
constexpr double kMostMoved = 0.1;  // squares, of a corner by its refinement; at least 3 px

struct Square {
  int column = 0, row = 0;
  friend bool operator<(const Square& a, const Square& b) {
    return std::pair(a.row, a.column) < std::pair(b.row, b.column);
  }
};

// Markers stand in the white squares, row by row.
Square SquareOf(const CharucoBoard& board, int index) {
  for (int row = 0;; ++row) {
    const int in_row = row % 2 == 0 ? board.columns / 2 : (board.columns + 1) / 2;
    if (index < in_row) return {2 * index + (row % 2 == 0 ? 1 : 0), row};
    index -= in_row;
  }
}

// A marker of the board, with the map from squares of the board to the photograph that its four
// corners give.
struct Placed {
  Quad corners;
  Matrix3d image_from_squares;
  Vector2d At(double x, double y) const {
    return (image_from_squares * Vector2d(x, y).homogeneous()).hnormalized();
  }
};

Placed Place(const Square& square, const Quad& corners) {
  constexpr double kSide = 0.6, kMargin = 0.2;
  Matrix3d unit_from_squares;
  unit_from_squares << 1 / kSide, 0, -(square.column + kMargin) / kSide,  //
      0, 1 / kSide, -(square.row + kMargin) / kSide,                      //
      0, 0, 1;
  return {corners, HomographyFromUnitSquare(corners) * unit_from_squares};
}

using PlacedMarkers = std::map<Square, Placed>;

double SideOf(const Placed& marker) {
  double sum = 0;
  for (std::size_t s = 0; s < 4; ++s) {
    sum += (marker.corners[(s + 1) % 4] - marker.corners[s]).norm() / 4;
  }
  return sum;
}

// Those that more of their neighbours confirm than deny: each predicts where the other one is.
PlacedMarkers Confirmed(const PlacedMarkers& markers) {
  constexpr double kSquaresPerMarker = 1 / 0.6;
  PlacedMarkers confirmed;
  for (const auto& [square, marker] : markers) {
    int votes = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const auto other = markers.find({square.column + dx, square.row + dy});
        if ((dx == 0 && dy == 0) || other == markers.end()) continue;
        const double x = other->first.column + 0.5, y = other->first.row + 0.5;
        const double off = (marker.At(x, y) - other->second.At(x, y)).norm();
        const double square_px =
            kSquaresPerMarker * std::min(SideOf(marker), SideOf(other->second));
        votes += off < kMostOff * square_px ? 1 : -1;
      }
    }
    if (votes > 0) confirmed.emplace(square, marker);
  }
  return confirmed;
}

// Those in the corner's two white squares, which lie across from each other.
std::vector<const Placed*> MarkersBeside(const PlacedMarkers& markers, int i, int j) {
  std::vector<const Placed*> beside;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const auto found = markers.find({i + dx, j + dy});
      if (found != markers.end()) beside.push_back(&found->second);
    }
  }
  return beside;
}

// sigma of the edges' Gaussian near a corner: a step C is C/(sqrt(2 pi) sigma) steep. The central
// difference adds 1/3, the pixel 1/12 to sigma^2.
double BlurAround(ImageSpan<const float> grey, const Vector2d& corner, int reach) {
  const int x0 = static_cast<int>(corner.x()), y0 = static_cast<int>(corner.y());
  float low = 1e9F, high = -1e9F, steepest = 0;
  for (int y = std::max(1, y0 - reach); y <= std::min(grey.height - 2, y0 + reach); ++y) {
    for (int x = std::max(1, x0 - reach); x <= std::min(grey.width - 2, x0 + reach); ++x) {
      low = std::min(low, grey(x, y));
      high = std::max(high, grey(x, y));
      steepest = std::max(
          steepest,
          std::hypot(grey(x + 1, y) - grey(x - 1, y), grey(x, y + 1) - grey(x, y - 1)) / 2);
    }
  }
  if (!(steepest > 0)) return 0;
  const auto sigma = static_cast<double>((high - low) / steepest) / std::sqrt(2 * std::numbers::pi);
  return std::sqrt(std::max(0.0, sigma * sigma - 5.0 / 12));
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<Saddle> CornerNear(ImageSpan<const float> grey,
                                 const std::vector<const Placed*>& beside, int i, int j,
                                 double noise) {
  Vector2d start(0, 0);
  double nearest = std::numeric_limits<double>::infinity(), square_px = 0;
  for (const Placed* marker : beside) {
    start += marker->At(i + 1, j + 1) / static_cast<double>(beside.size());
    square_px = std::max(square_px, SideOf(*marker) / 0.6);
  }
  for (const Placed* marker : beside) {
    for (const Vector2d& corner : marker->corners) {
      nearest = std::min(nearest, (corner - start).norm());
    }
  }
  const int half_window =
      std::min(kMostHalfWindow, static_cast<int>(std::floor(nearest)) - kMarkerMargin);
  if (half_window < kLeastHalfWindow) return std::nullopt;
  auto saddle = RefineSaddle(grey, start, half_window, noise);
  if (saddle && (saddle->position_px - start).norm() > std::max(3.0, kMostMoved * square_px)) {
    return std::nullopt;
  }
  return saddle;
}

// The markers of each board and handedness.
using Groups = std::map<std::pair<std::size_t, bool>, std::vector<FoundMarker>>;

Groups GroupMarkers(const std::vector<FoundMarker>& found,
                    const std::vector<CharucoBoard>& boards) {
  Groups groups;
  for (const FoundMarker& marker : found) {
    for (std::size_t b = 0; b < boards.size(); ++b) {
      const int index = marker.id - boards[b].first_id;
      if (index < 0 || index >= boards[b].num_markers()) continue;
      groups[{b, marker.mirrored}].push_back(marker);
    }
  }
  return groups;
}

// One identity seen at two places is none.
PlacedMarkers PlaceAll(const std::vector<FoundMarker>& found, const CharucoBoard& board) {
  std::map<int, int> times;
  for (const FoundMarker& marker : found) ++times[marker.id];
  PlacedMarkers placed;
  for (const FoundMarker& marker : found) {
    if (times[marker.id] > 1) continue;
    const Square square = SquareOf(board, marker.id - board.first_id);
    placed.emplace(square, Place(square, marker.corners));
  }
  return placed;
}

// The 99th percentile.
double BrightLevel(ImageSpan<const float> grey) {
  constexpr int kStep = 3;
  std::vector<float> values;
  for (int y = 0; y < grey.height; y += kStep) {
    for (int x = 0; x < grey.width; x += kStep) values.push_back(grey(x, y));
  }
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

}  // namespace

std::optional<BoardSighting> DetectBoard(ImageSpan<const float> grey,
                                         const std::vector<CharucoBoard>& boards) {
  constexpr double kLeastContrastOfBright = 0.06, kLeastContrastOfNoise = 10;
  const double noise = EstimateNoise(grey);
  const std::vector<FoundMarker> found =
      FindMarkers(grey, static_cast<float>(std::max(kLeastContrastOfBright * BrightLevel(grey),
                                                    kLeastContrastOfNoise * noise)));
  const Groups groups = GroupMarkers(found, boards);
  const auto most = std::max_element(
      groups.begin(), groups.end(),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  if (most == groups.end()) return std::nullopt;
  for (const auto& [key, markers] : groups) {
    if (key != most->first &&
        kRatio * static_cast<double>(markers.size()) > static_cast<double>(most->second.size())) {
      return std::nullopt;
    }
  }
  const CharucoBoard& board = boards[most->first.first];
  const PlacedMarkers markers = Confirmed(PlaceAll(most->second, board));
  if (static_cast<int>(markers.size()) < kLeastMarkers) return std::nullopt;
  BoardSighting sighting{most->first.first,
                         most->first.second,
                         static_cast<int>(markers.size()),
                         static_cast<int>(found.size() - markers.size()),
                         0,
                         0,
                         {}};
  std::vector<double> scales, blurs;
  for (const auto& [square, marker] : markers) scales.push_back(SideOf(marker) / board.marker_px());
  sighting.scale = Median(scales);
  for (int corner = 0; corner < board.num_corners(); ++corner) {
    const int i = corner % (board.columns - 1), j = corner / (board.columns - 1);
    const auto beside = MarkersBeside(markers, i, j);
    if (beside.empty()) continue;
    const auto saddle = CornerNear(grey, beside, i, j, noise);
    if (!saddle) continue;
    sighting.points.push_back(
        {board.CornerPx(corner), saddle->position_px, saddle->covariance_px2});
    blurs.push_back(BlurAround(grey, saddle->position_px, kMostHalfWindow));
  }
  sighting.blur_px = Median(blurs);
  return sighting;
}

}  // namespace lamella
