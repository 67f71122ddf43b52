#include "calibration/aruco_markers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#include <opencv2/objdetect/charuco_detector.hpp>
#else
#include <opencv2/aruco/charuco.hpp>
#endif

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

using CornerLists = std::vector<std::vector<cv::Point2f>>;

#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
const cv::aruco::Dictionary& Dictionary() {
  static const cv::aruco::Dictionary dictionary =
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_1000);
  return dictionary;
}

void Detect(const cv::Mat& grey, const cv::aruco::DetectorParameters& parameters,
            CornerLists& corners, std::vector<int>& ids) {
  cv::aruco::ArucoDetector(Dictionary(), parameters).detectMarkers(grey, corners, ids);
}

void Draw(cv::Size squares, int square_px, int marker_px, const std::vector<int>& ids,
          cv::Mat& image) {
  cv::aruco::CharucoBoard(squares, static_cast<float>(square_px), static_cast<float>(marker_px),
                          Dictionary(), ids)
      .generateImage(squares * square_px, image);
}
#else
const cv::aruco::Dictionary& Dictionary() {
  static const cv::Ptr<cv::aruco::Dictionary> dictionary =
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_1000);
  return *dictionary;
}

void Detect(const cv::Mat& grey, const cv::aruco::DetectorParameters& parameters,
            CornerLists& corners, std::vector<int>& ids) {
  cv::aruco::detectMarkers(grey, cv::makePtr<cv::aruco::Dictionary>(Dictionary()), corners, ids,
                           cv::makePtr<cv::aruco::DetectorParameters>(parameters));
}

void Draw(cv::Size squares, int square_px, int marker_px, const std::vector<int>& ids,
          cv::Mat& image) {
  const auto board = cv::aruco::CharucoBoard::create(
      squares.width, squares.height, static_cast<float>(square_px), static_cast<float>(marker_px),
      cv::makePtr<cv::aruco::Dictionary>(Dictionary()));
  board->setIds(ids);
  board->draw(squares * square_px, image);
}
#endif

constexpr int kLeastSidePx = 10;

cv::aruco::DetectorParameters Parameters(cv::Size photo) {
  cv::aruco::DetectorParameters parameters;
  // One threshold, against the mean of 13 x 13 px. More of them take longer and find little that
  // is not read later, where found markers put it (detect_board.h).
  parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = 13;
  // OpenCV's default grows with the photograph: squares of 32 px in 5 Mpx are too small for it.
  parameters.minMarkerPerimeterRate = 4.0 * kLeastSidePx / std::max(photo.width, photo.height);
  // Blur reaches a third into a small module.
  parameters.perspectiveRemoveIgnoredMarginPerCell = 0.33;
  return parameters;
}

cv::Mat MatOf(ImageSpan<const std::uint8_t> grey) {
  cv::Mat copy(grey.height, grey.width, CV_8UC1);
  for (int y = 0; y < grey.height; ++y) {
    std::copy_n(grey.row(y), grey.width, copy.ptr<std::uint8_t>(y));
  }
  return copy;
}

// In OpenCV's pixels.
std::vector<FoundMarker> DetectIn(const cv::Mat& grey) {
  std::vector<FoundMarker> markers;
  CornerLists corners;
  std::vector<int> ids;
  Detect(grey, Parameters(grey.size()), corners, ids);
  for (std::size_t m = 0; m < ids.size(); ++m) {
    FoundMarker marker{ids[m], {}};
    for (std::size_t c = 0; c < 4; ++c) {
      marker.corners[c] = Vector2d(static_cast<double>(corners[m][c].x),  //
                                   static_cast<double>(corners[m][c].y));
    }
    markers.push_back(marker);
  }
  return markers;
}

// OpenCV's corners are the middles of the outermost dark pixels: the edges lie half a pixel further
// out.
Quad Widened(const Quad& inner) {
  Quad outer = inner;
  for (std::size_t c = 0; c < 4; ++c) {
    for (const std::size_t next : {(c + 1) % 4, (c + 3) % 4}) {
      outer[c] += 0.5 * (inner[c] - inner[next]).normalized();
    }
  }
  return outer;
}

// What to add to OpenCV's pixels, measured: releases differ in where they say that corners are, and
// half a pixel would part what a mirror shows from what is seen directly. A small board is drawn
// and searched; every marker must be where charuco_board.h lays it out.
double MeasureOffset() {
  constexpr int kColumns = 4, kRows = 3, kSquare = 40, kMarker = 24, kFirstId = 7, kAround = 40;
  const Image<std::uint8_t> board = DrawCharuco(kColumns, kRows, kSquare, kMarker, kFirstId);
  cv::Mat image(board.height() + 2 * kAround, board.width() + 2 * kAround, CV_8UC1, 255.0);
  MatOf(board.span()).copyTo(image(cv::Rect(kAround, kAround, board.width(), board.height())));
  const std::vector<FoundMarker> found = DetectIn(image);
  double sum = 0, worst = 0;
  for (const FoundMarker& marker : found) {
    // Two markers a row, from the second square in even rows.
    const int index = marker.id - kFirstId, row = index / 2;
    const int column = 2 * (index % 2) + (row % 2 == 0 ? 1 : 0);
    const Vector2d truth = Vector2d(column + 0.5, row + 0.5) * kSquare + Vector2d(kAround, kAround);
    const Vector2d middle =
        (marker.corners[0] + marker.corners[1] + marker.corners[2] + marker.corners[3]) / 4;
    sum += (truth - middle).mean() / static_cast<double>(found.size());
    worst = std::max(worst, (truth - middle).cwiseAbs().maxCoeff());
  }
  const double offset = std::round(2 * sum) / 2;
  if (found.size() != kColumns * kRows / 2 || worst > 1 || std::abs(sum - offset) > 0.1) {
    throw MachineError(fmt::format("OpenCV {}", cv::getVersionString()),
                       fmt::format("finds {} of the {} markers of its own board, {:.2f} px off",
                                   found.size(), kColumns * kRows / 2, worst),
                       "install another release");
  }
  return offset;
}

double PixelOffset() {
  static const double offset = [] {
    cv::setNumThreads(0);  // threads are ours (lightfield/parallel.h)
    return MeasureOffset();
  }();
  return offset;
}

}  // namespace

MarkerBits BitsOfMarker(int id) {
  const cv::aruco::Dictionary& dictionary = Dictionary();
  const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(
      dictionary.bytesList.rowRange(id, id + 1), kMarkerModules);
  MarkerBits packed = 0;
  for (int j = 0; j < kMarkerModules; ++j) {
    for (int i = 0; i < kMarkerModules; ++i) {
      if (bits.at<std::uint8_t>(j, i) != 0) packed |= 1U << (i + kMarkerModules * j);
    }
  }
  return packed;
}

std::vector<FoundMarker> FindMarkers(ImageSpan<const std::uint8_t> grey, bool mirrored) {
  if (std::min(grey.width, grey.height) < kLeastSidePx) return {};
  const double offset = PixelOffset();
  cv::Mat image = MatOf(grey);
  if (mirrored) cv::flip(image, image, 1);
  std::vector<FoundMarker> markers = DetectIn(image);
  for (FoundMarker& marker : markers) {
    marker.corners = Widened(marker.corners);
    for (Vector2d& corner : marker.corners) {
      corner.array() += offset;
      if (mirrored) corner.x() = grey.width - corner.x();
    }
  }
  return markers;
}

Image<std::uint8_t> DrawCharuco(int columns, int rows, int square_px, int marker_px, int first_id) {
  std::vector<int> ids(static_cast<std::size_t>(columns * rows / 2));
  std::iota(ids.begin(), ids.end(), first_id);
  cv::Mat drawn;
  Draw({columns, rows}, square_px, marker_px, ids, drawn);
  Image<std::uint8_t> image(drawn.cols, drawn.rows);
  for (int y = 0; y < drawn.rows; ++y) {
    std::copy_n(drawn.ptr<std::uint8_t>(y), drawn.cols, image.row(y));
  }
  return image;
}

}  // namespace lamella
