// Boards against OpenCV's own reading of them, markers against their places in photographs.
#include "calibration/aruco_markers.h"

#include <cmath>
#include <set>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#include <opencv2/objdetect/charuco_detector.hpp>
#else
#include <opencv2/aruco/charuco.hpp>
#endif

#include "calibration/charuco_board.h"
#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

CharucoBoard Board(std::size_t which) {
  return LayOutBoards({{1920, 1080}, {1920, 1080}, {1920, 1080}, {1920, 1080}})[which];
}

struct Corners {
  std::vector<cv::Point2f> points;
  std::vector<int> ids;
};

// As any program reads such a board with OpenCV.
Corners CornersOf(const cv::Mat& image, const CharucoBoard& board) {
  std::vector<int> ids;
  for (int m = 0; m < board.num_markers(); ++m) ids.push_back(board.first_id + m);
  Corners corners;
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
  const cv::aruco::CharucoBoard charuco(
      {board.columns, board.rows}, 1, 0.6F,
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_1000), ids);
  cv::aruco::CharucoDetector(charuco).detectBoard(image, corners.points, corners.ids);
#else
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_1000);
  const auto charuco =
      cv::aruco::CharucoBoard::create(board.columns, board.rows, 1, 0.6F, dictionary);
  charuco->setIds(ids);
  std::vector<std::vector<cv::Point2f> > markers;
  std::vector<int> found;
  cv::aruco::detectMarkers(image, dictionary, markers, found);
  cv::aruco::interpolateCornersCharuco(markers, found, image, charuco, corners.points, corners.ids);
#endif
  return corners;
}

TEST(DrawBoard, IsReadByOpenCv) {
  const CharucoBoard board = Board(2);
  const Image<Rgb8> drawn = DrawBoard(board);
  cv::Mat image(drawn.height(), drawn.width(), CV_8UC1);
  for (int v = 0; v < drawn.height(); ++v) {
    for (int u = 0; u < drawn.width(); ++u) image.at<std::uint8_t>(v, u) = drawn(u, v).g;
  }
  const Corners corners = CornersOf(image, board);
  ASSERT_EQ(corners.ids.size(), static_cast<std::size_t>(board.num_corners()));
  for (std::size_t c = 0; c < corners.ids.size(); ++c) {
    // Releases of OpenCV differ by half a pixel in these.
    const Vector2d at = board.CornerPx(corners.ids[c]);
    EXPECT_NEAR(static_cast<double>(corners.points[c].x), at.x() - 0.25, 0.3);
    EXPECT_NEAR(static_cast<double>(corners.points[c].y), at.y() - 0.25, 0.3);
  }
}

Image<std::uint8_t> PhotoOf(const PanelView& view, const CharucoBoard& board) {
  const Image<float> photo = Exposed(view.Photograph(DrawBoard(board).span()).span(), {}, 1);
  Image<std::uint8_t> codes(photo.width(), photo.height());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes.data()[i] = static_cast<std::uint8_t>(std::lround(255 * photo.data()[i]));
  }
  return codes;
}

// Directly and in a mirror, where a wrong half pixel would show with the other sign.
TEST(FindMarkers, PutsThemWhereTheyAre) {
  const CharucoBoard board = Board(1);
  for (const bool mirrored : {false, true}) {
    PanelViewOptions options;
    options.width_px = 480;
    options.height_px = 360;
    options.roll_deg = 15;
    options.mirrored = mirrored;
    const PanelView view(1920, 1080, options);
    const Image<std::uint8_t> photo = PhotoOf(view, board);
    const auto found = FindMarkers(photo.span(), mirrored);
    EXPECT_GT(found.size(), 8U);
    Vector2d bias(0, 0);
    for (const FoundMarker& marker : found) {
      const int index = marker.id - board.first_id, pair = index / 24;  // 24 in two rows
      const int row = 2 * pair + (index % 24 >= 12 ? 1 : 0);
      const int column = 2 * (index % 12) + (row % 2 == 0 ? 1 : 0);
      ASSERT_TRUE(index >= 0 && index < board.num_markers()) << marker.id;
      const double side = board.marker_px();
      const Vector2d top_left(board.left_px + (column + 0.2) * board.square_px,
                              board.top_px + (row + 0.2) * board.square_px);
      const Vector2d offsets[] = {{0, 0}, {side, 0}, {side, side}, {0, side}};
      for (std::size_t c = 0; c < 4; ++c) {
        const Vector2d error = marker.corners[c] - view.ImageFromPanel(top_left + offsets[c]);
        EXPECT_LT(error.norm(), 1.2) << marker.id << " " << c;
        bias += error / static_cast<double>(4 * found.size());
      }
    }
    EXPECT_LT(bias.norm(), 0.1);
    // The other handedness shows hardly any, and none in order.
    EXPECT_LT(FindMarkers(photo.span(), !mirrored).size(), 5U);
  }
}

TEST(FindMarkers, FindsNothingWhereThereIsNothing) {
  EXPECT_TRUE(FindMarkers(Image<std::uint8_t>().span(), false).empty());
  EXPECT_TRUE(FindMarkers(Image<std::uint8_t>(1, 1).span(), true).empty());
  EXPECT_TRUE(FindMarkers(Image<std::uint8_t>(400, 300, 128).span(), false).empty());
}

// The drawing has the modules at whole multiples of 8 px.
TEST(BitsOfMarker, AreThoseThatAreDrawn) {
  constexpr int kMarker = 56, kSquare = 80, kMargin = 12, kModule = 8;
  std::set<MarkerBits> all;
  for (const int id : {0, 1, 500, 998}) {
    // 3 x 3 squares: the first marker stands in the second square.
    const Image<std::uint8_t> board = DrawCharuco(3, 3, kSquare, kMarker, std::min(id, 996));
    const int place = id - std::min(id, 996);  // 0, or 2: the second row's second
    const int left = kMargin + (place == 0 ? 1 : 2) * kSquare;
    const int top = kMargin + (place == 0 ? 0 : 1) * kSquare;
    for (int j = 0; j < kMarkerSideModules; ++j) {
      for (int i = 0; i < kMarkerSideModules; ++i) {
        const bool border =
            i == 0 || j == 0 || i == kMarkerSideModules - 1 || j == kMarkerSideModules - 1;
        const bool white =
            !border && (BitsOfMarker(id) >> (i - 1 + kMarkerModules * (j - 1)) & 1U) != 0;
        EXPECT_EQ(board(left + i * kModule + 4, top + j * kModule + 4), white ? 255 : 0)
            << id << " " << i << " " << j;
      }
    }
  }
  for (int id = 0; id < kNumMarkers; ++id) all.insert(BitsOfMarker(id));
  EXPECT_EQ(all.size(), static_cast<std::size_t>(kNumMarkers));
}

}  // namespace
}  // namespace lamella
