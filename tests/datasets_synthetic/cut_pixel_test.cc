#include "datasets_synthetic/cut_pixel.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace lamella {
namespace {

// (x, y) of the camera's pixel to a point on each panel.
OnPanels OnBoth(double x, double y) {
  return {3.7 + 0.9 * x - 0.3 * y, 1.2 + 0.2 * x + 0.8 * y, 8.9 + 0.5 * x, 5.6 - 1.1 * y};
}

std::array<OnPanels, 4> CornersOnBoth() {
  return {OnBoth(0, 0), OnBoth(1, 0), OnBoth(1, 1), OnBoth(0, 1)};
}

// The panels' pixels that a point is in.
std::array<int, 4> CellsOf(const OnPanels& point, const std::vector<int>& axes) {
  std::array<int, 4> cells{};
  for (const int axis : axes) {
    cells[static_cast<std::size_t>(axis)] = static_cast<int>(std::floor(point[axis]));
  }
  return cells;
}

TEST(CutPixel, SharesItOutAsCountedPointsDo) {
  for (const std::vector<int>& axes :
       {std::vector<int>{0, 1}, std::vector<int>{2, 3}, std::vector<int>{0, 1, 2, 3}}) {
    std::map<std::array<int, 4>, double> counted, cut;
    constexpr int kSide = 400;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int column = i % kSide, row = i / kSide;
      const OnPanels point = OnBoth((column + 0.5) / kSide, (row + 0.5) / kSide);
      counted[CellsOf(point, axes)] += 1.0 / (kSide * kSide);
    }
    double sum = 0;
    EXPECT_TRUE(CutPixel(CornersOnBoth(), axes, [&](const OnPanels& within, double share) {
      cut[CellsOf(within, axes)] += share;
      sum += share;
    }));
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_GT(counted.size(), 3U);
    ASSERT_EQ(cut.size(), counted.size());
    for (const auto& [cells, share] : counted) EXPECT_NEAR(cut[cells], share, 2e-3);
  }
}

TEST(CutPixel, LeavesAPixelThatLiesInOneCellWhole) {
  int pieces = 0;
  const std::array<OnPanels, 4> corners = {OnPanels(2, 3, 0, 0), OnPanels(3, 3, 0, 0),
                                           OnPanels(3, 4, 0, 0), OnPanels(2, 4, 0, 0)};
  EXPECT_TRUE(CutPixel(corners, {0, 1}, [&](const OnPanels& within, double share) {
    ++pieces;
    EXPECT_EQ(share, 1);
    EXPECT_EQ(within, OnPanels(2.5, 3.5, 0, 0));
  }));
  EXPECT_EQ(pieces, 1);
}

TEST(CutPixel, RefusesManyPiecesNoAreaAndWhatFoldsOver) {
  std::array<OnPanels, 4> corners = CornersOnBoth();
  const auto never = [](const OnPanels&, double) { ADD_FAILURE(); };
  for (OnPanels& corner : corners) corner *= 100;
  EXPECT_FALSE(CutPixel(corners, {0, 1}, never));
  corners = CornersOnBoth();
  std::swap(corners[0], corners[1]);
  EXPECT_FALSE(CutPixel(corners, {0, 1}, never));
  EXPECT_FALSE(CutPixel(corners, {2, 3}, never));
  corners.fill(OnBoth(0.5, 0.5));
  EXPECT_FALSE(CutPixel(corners, {0, 1}, never));
  corners[0][0] = std::nan("");
  EXPECT_FALSE(CutPixel(corners, {0, 1}, never));
}

}  // namespace
}  // namespace lamella
