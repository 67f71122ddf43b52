#include "calibration/chessboard.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr int kSquare = 40;

// Of 10 x 7 squares, with a white border of half a square.
Image<Rgb8> Board() {
  Image<Rgb8> board(11 * kSquare, 8 * kSquare, {255, 255, 255});
  for (int v = 0; v < 7 * kSquare; ++v) {
    for (int u = 0; u < 10 * kSquare; ++u) {
      if ((u / kSquare + v / kSquare) % 2 == 0) board(u + kSquare / 2, v + kSquare / 2) = {};
    }
  }
  return board;
}

TEST(FindChessboard, FindsAllCornersInOrder) {
  const Image<Rgb8> board = Board();
  for (const double roll : {0.0, 25.0, 80.0, 170.0, 300.0}) {
    PanelViewOptions options;
    options.roll_deg = roll;
    options.yaw_deg = 20;
    options.focal_px = 900;
    options.width_px = options.height_px = 500;
    const PanelView view(board.width(), board.height(), options);
    const Image<float> photo = Exposed(view.Photograph(board.span()).span(), {}, 1);
    const auto corners = FindChessboard(photo.span(), 9, 6);
    ASSERT_TRUE(corners) << roll;
    ASSERT_EQ(corners->size(), 54U);
    // In the board's order, or turned by 180 degrees, so that rows run to the right.
    std::vector<Vector2d> truth;
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 9; ++i) {
        truth.push_back(view.ImageFromPanel({(i + 1.5) * kSquare, (j + 1.5) * kSquare}));
      }
    }
    if (truth[8].x() < truth[0].x()) std::reverse(truth.begin(), truth.end());
    double sum = 0;
    for (std::size_t i = 0; i < 54; ++i) {
      EXPECT_LT(((*corners)[i].position_px - truth[i]).norm(), 0.15) << roll << " " << i;
      sum += ((*corners)[i].position_px - truth[i]).squaredNorm() / 2;
    }
    EXPECT_LT(std::sqrt(sum / 54), 0.03) << roll;
  }
}

TEST(FindChessboard, FindsNoOtherBoard) {
  const Image<Rgb8> board = Board();
  PanelViewOptions options;
  const Image<float> light =
      PanelView(board.width(), board.height(), options).Photograph(board.span());
  const Image<float> photo = Exposed(light.span(), {}, 1);
  EXPECT_TRUE(FindChessboard(photo.span(), 9, 6));
  EXPECT_TRUE(FindChessboard(photo.span(), 6, 9));
  EXPECT_FALSE(FindChessboard(photo.span(), 8, 6));
  EXPECT_FALSE(FindChessboard(Image<float>(100, 100, 0.5F).span(), 9, 6));
  EXPECT_FALSE(FindChessboard(Image<float>(1, 1).span(), 9, 6));
}

}  // namespace
}  // namespace lamella
