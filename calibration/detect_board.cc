#include "calibration/detect_board.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "calibration/aruco_markers.h"
#include "calibration/homography.h"
#include "calibration/read_marker.h"
#include "calibration/saddle.h"
#include "lightfield/median.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kLeastHalfWindow = 4;
constexpr double kOfNearestMarker = 0.75;  // a corner on the window's diagonal weighs 0.01
constexpr double kBorder = 3;              // of the photograph; a start is some px off
constexpr double kRatio = 10;              // of markers, between the board and anything else
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
double BlurAround(ImageSpan<const float> grey, const Vector2d& corner) {
  constexpr int kReach = 9;
  const int x0 = static_cast<int>(corner.x()), y0 = static_cast<int>(corner.y());
  float low = 1e9F, high = -1e9F, steepest = 0;
  for (int y = std::max(1, y0 - kReach); y <= std::min(grey.height - 2, y0 + kReach); ++y) {
    for (int x = std::max(1, x0 - kReach); x <= std::min(grey.width - 2, x0 + kReach); ++x) {
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

std::optional<Saddle> CornerNear(ImageSpan<const float> grey,
                                 const std::vector<const Placed*>& beside, int i, int j,
                                 const NoiseCurve& noise) {
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
  const double to_border =
      std::min({start.x(), start.y(), grey.width - start.x(), grey.height - start.y()});
  const auto half_window = static_cast<int>(
      std::min({double{kMostHalfWindow}, kOfNearestMarker * nearest, to_border - kBorder}));
  if (half_window < kLeastHalfWindow) return std::nullopt;
  auto saddle = RefineSaddle(grey, start, half_window, noise);
  if (saddle && (saddle->position_px - start).norm() > std::max(3.0, kMostMoved * square_px)) {
    return std::nullopt;
  }
  return saddle;
}

// The deviation that pixels leave where they sample edges too coarsely: the amplitude of an edge's
// first alias, of pixel, central difference and half the blur's variance (edges of both directions
// pass a corner). 0.0007 px at a blur of 0.7 px, 0.006 at 0.5, 0.02 at 0.35.
double AliasPx(double blur_px) {
  const double variance = (blur_px * blur_px + 5.0 / 12) / 2;
  const double pi2 = std::numbers::pi * std::numbers::pi;
  return 4 * std::numbers::pi * variance * std::exp(-2 * pi2 * variance);
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

// A board in a photograph: its markers, and the corners beside them.
class Reader {
 public:
  Reader(ImageSpan<const float> grey, const CharucoBoard& board, PlacedMarkers markers,
         const NoiseCurve& noise, double least_contrast)
      : grey_(grey),
        board_(board),
        markers_(std::move(markers)),
        noise_(noise),
        least_contrast_(least_contrast),
        corners_(static_cast<std::size_t>(board.num_corners())) {
    for (const auto& [square, marker] : markers_) RefineBeside(square);
  }

  // Markers beyond those that were found are read where the corners around put them, as far as
  // that leads.
  void ReadMissing() {
    for (bool more = true; more;) {
      PlacedMarkers read;
      for (int m = 0; m < board_.num_markers(); ++m) {
        const Square square = SquareOf(board_, m);
        if (markers_.contains(square)) continue;
        const auto marker = Predicted(square);
        if (!marker) continue;
        if (ShowsMarker(grey_, marker->corners, board_.first_id + m, least_contrast_)) {
          read.emplace(square, *marker);
        }
      }
      more = !read.empty();
      markers_.insert(read.begin(), read.end());
      for (const auto& [square, marker] : read) RefineBeside(square);
    }
  }

  const PlacedMarkers& markers() const { return markers_; }
  const std::vector<std::optional<Saddle>>& corners() const { return corners_; }

 private:
  std::optional<Saddle>* CornerAt(int i, int j) {
    if (i < 0 || j < 0 || i >= board_.columns - 1 || j >= board_.rows - 1) return nullptr;
    const int corner = i + j * (board_.columns - 1);
    return &corners_[static_cast<std::size_t>(corner)];
  }

  void RefineBeside(const Square& square) {
    for (int j = square.row - 1; j <= square.row; ++j) {
      for (int i = square.column - 1; i <= square.column; ++i) {
        std::optional<Saddle>* corner = CornerAt(i, j);
        if (corner == nullptr || *corner) continue;
        *corner = CornerNear(grey_, MarkersBeside(markers_, i, j), i, j, noise_);
      }
    }
  }

  // By the homography of the corners within two squares.
  std::optional<Placed> Predicted(const Square& square) {
    constexpr int kReach = 2, kLeastCorners = 6;
    constexpr double kMargin = 0.2;
    std::vector<Vector2d> on_board, in_image;
    for (int j = square.row - 1 - kReach; j <= square.row + kReach; ++j) {
      for (int i = square.column - 1 - kReach; i <= square.column + kReach; ++i) {
        const std::optional<Saddle>* corner = CornerAt(i, j);
        if (corner == nullptr || !*corner) continue;
        on_board.emplace_back(i + 1, j + 1);
        in_image.push_back((*corner)->position_px);
      }
    }
    if (on_board.size() < kLeastCorners) return std::nullopt;
    const auto columns = [](const std::vector<Vector2d>& points) {
      return Eigen::Map<const Eigen::Matrix2Xd>(points.front().data(), 2,
                                                static_cast<Eigen::Index>(points.size()));
    };
    const auto image_from_squares = FitHomography(columns(on_board), columns(in_image));
    if (!image_from_squares) return std::nullopt;
    Placed marker{{}, *image_from_squares};
    const double left = square.column + kMargin, right = square.column + 1 - kMargin;
    const double top = square.row + kMargin, bottom = square.row + 1 - kMargin;
    marker.corners = {marker.At(left, top), marker.At(right, top), marker.At(right, bottom),
                      marker.At(left, bottom)};
    return marker;
  }

  ImageSpan<const float> grey_;
  const CharucoBoard& board_;
  PlacedMarkers markers_;
  const NoiseCurve& noise_;
  double least_contrast_;
  std::vector<std::optional<Saddle>> corners_;
};

// A board and handedness, and its markers that confirm each other.
struct BoardCandidate {
  std::size_t board = 0;
  bool mirrored = false;
  PlacedMarkers markers;
};

std::vector<BoardCandidate> FindCandidates(const Image<std::uint8_t>& codes,
                                           const std::vector<CharucoBoard>& boards) {
  std::vector<BoardCandidate> candidates;
  for (const bool mirrored : {false, true}) {
    const std::vector<FoundMarker> found = FindMarkers(codes.span(), mirrored);
    for (std::size_t b = 0; b < boards.size(); ++b) {
      std::vector<FoundMarker> of_board;
      std::copy_if(found.begin(), found.end(), std::back_inserter(of_board),
                   [&](const FoundMarker& marker) {
                     const int index = marker.id - boards[b].first_id;
                     return index >= 0 && index < boards[b].num_markers();
                   });
      candidates.push_back({b, mirrored, Confirmed(PlaceAll(of_board, boards[b]))});
    }
  }
  return candidates;
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

// 8 bits, the brightest near full scale, as far as noise stays well within the 7 codes by which
// OpenCV's threshold passes what is dark: noise would be full of outlines.
Image<std::uint8_t> Codes(ImageSpan<const float> grey, double bright, double noise) {
  constexpr double kWhite = 230, kMostNoise = 3;
  const auto scale =
      static_cast<float>(std::min(kWhite / std::max(bright, 1e-6), kMostNoise / noise));
  Image<std::uint8_t> codes(grey.width, grey.height);
  for (int y = 0; y < grey.height; ++y) {
    std::transform(grey.row(y), grey.row(y) + grey.width, codes.row(y), [scale](float value) {
      return static_cast<std::uint8_t>(std::clamp(scale * value + 0.5F, 0.0F, 255.0F));
    });
  }
  return codes;
}

BoardSighting SightingOf(ImageSpan<const float> grey, const BoardCandidate& candidate,
                         const CharucoBoard& board, const Reader& reader) {
  BoardSighting sighting{
      candidate.board, candidate.mirrored, static_cast<int>(reader.markers().size()), 0, 0, {}};
  std::vector<double> scales, blurs;
  for (const auto& [square, marker] : reader.markers()) {
    scales.push_back(SideOf(marker) / board.marker_px());
  }
  for (std::size_t c = 0; c < reader.corners().size(); ++c) {
    const std::optional<Saddle>& saddle = reader.corners()[c];
    if (!saddle) continue;
    sighting.points.push_back(
        {board.CornerPx(static_cast<int>(c)), saddle->position_px, saddle->covariance_px2});
    blurs.push_back(BlurAround(grey, saddle->position_px));
  }
  sighting.scale = Median(scales);
  sighting.blur_px = Median(blurs);
  const double alias_px = AliasPx(sighting.blur_px);
  for (Observation& point : sighting.points) {
    point.covariance_px2 += alias_px * alias_px * Eigen::Matrix2d::Identity();
  }
  return sighting;
}

}  // namespace

std::optional<BoardSighting> DetectBoard(ImageSpan<const float> grey,
                                         const std::vector<CharucoBoard>& boards) {
  constexpr double kLeastContrastOfBright = 0.06, kLeastContrastOfNoise = 10;
  const NoiseCurve noise(grey);
  const double bright = BrightLevel(grey);
  const double least_contrast =
      std::max(kLeastContrastOfBright * bright, kLeastContrastOfNoise * noise.MedianDeviation());
  std::vector<BoardCandidate> candidates =
      FindCandidates(Codes(grey, bright, noise.MedianDeviation()), boards);
  const auto most = std::max_element(candidates.begin(), candidates.end(),
                                     [](const BoardCandidate& a, const BoardCandidate& b) {
                                       return a.markers.size() < b.markers.size();
                                     });
  if (most == candidates.end() || most->markers.empty()) return std::nullopt;
  const CharucoBoard& board = boards[most->board];
  Reader reader(grey, board, most->markers, noise, least_contrast);
  reader.ReadMissing();
  const auto count = static_cast<double>(reader.markers().size());
  if (count < kLeastMarkers) return std::nullopt;
  for (auto other = candidates.begin(); other != candidates.end(); ++other) {
    if (other != most && kRatio * static_cast<double>(other->markers.size()) > count) {
      return std::nullopt;
    }
  }
  return SightingOf(grey, *most, board, reader);
}

}  // namespace lamella
