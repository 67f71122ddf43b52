#include "calibration/gray_code.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

std::vector<Image<float>> Taken(const PanelView& view, const GrayCodePatterns& patterns) {
  std::vector<Image<float>> photos;
  for (std::size_t i = 0; i < patterns.Count(); ++i) {
    const Image<Rgb8> pattern = DrawGrayCode(patterns, i);
    photos.push_back(
        Exposed(view.Photograph(pattern.span()).span(), {}, static_cast<std::uint32_t>(i + 1)));
  }
  return photos;
}

ScreenMap Decoded(const GrayCodePatterns& patterns, const std::vector<Image<float>>& photos) {
  return DecodeGrayCode(patterns, [&](std::size_t i) { return photos[i].Clone(); });
}

// OpenCV: 42 images for a projector of 1024 x 768.
TEST(GrayCode, NeedsAsManyPhotographsAsOpenCvTakes) {
  EXPECT_EQ((GrayCodePatterns{1024, 768, 1}).Count(), 42U);
  EXPECT_EQ((GrayCodePatterns{1920, 1080, 8}).Count(), 2U * (8 + 8 + 1));
}

TEST(GrayCode, HasStripesByHand) {
  const GrayCodePatterns patterns{8, 2, 1};
  const auto row = [&](std::size_t i) {
    const Image<Rgb8> image = DrawGrayCode(patterns, i);
    std::string text;
    for (int u = 0; u < 8; ++u) text += image(u, 0).g == 255 ? '1' : '0';
    return text;
  };
  EXPECT_EQ(row(0), "00001111");
  EXPECT_EQ(row(1), "11110000");
  EXPECT_EQ(row(2), "00111100");
  EXPECT_EQ(row(4), "01100110");
  EXPECT_EQ(row(6), "00000000");  // the row's bit
  EXPECT_EQ(row(8), "11111111");
  EXPECT_EQ(row(9), "00000000");
}

TEST(DecodeGrayCode, TellsTheCellThatEveryPixelSees) {
  PanelViewOptions options;
  options.width_px = 240;
  options.height_px = 180;
  options.scale = 3;
  options.roll_deg = 12;
  options.yaw_deg = 15;
  options.blur_px = 0.7;
  options.middle_u = 0.8;
  const PanelView view(1000, 700, options);
  const GrayCodePatterns patterns{1000, 700, 1};
  const ScreenMap map = Decoded(patterns, Taken(view, patterns));
  int count = 0;
  for (int y = 0; y < 180; ++y) {
    for (int x = 0; x < 240; ++x) {
      if (map.valid(x, y) == 0) continue;
      const Vector2d truth = view.PanelFromImage({x + 0.5, y + 0.5});
      ASSERT_LT(std::abs(static_cast<double>(map.u_px(x, y)) - truth.x()), 0.9);
      ASSERT_LT(std::abs(static_cast<double>(map.v_px(x, y)) - truth.y()), 0.9);
      ++count;
    }
  }
  EXPECT_GT(count, 240 * 180 / 3);
  // As screen correspondences.
  std::vector<Vector2d> nodes;
  const Vector2d middle = view.PanelFromImage({120, 90});
  for (int i = -2; i <= 2; ++i) nodes.emplace_back(middle + Vector2d(12 * i, 7 * i));
  for (const Observation& node : ObserveNodes(map, nodes)) {
    EXPECT_LT((node.image_px - view.ImageFromPanel(node.panel_px)).norm(), 0.15);
  }
  EXPECT_EQ(ObserveNodes(map, nodes).size(), 5U);
}

// 94 px in cells of 8: the last column of cells is 6 px wide.
TEST(DecodeGrayCode, KnowsANarrowerLastCellBetter) {
  PanelViewOptions options;
  options.width_px = 120;
  options.height_px = 90;
  const PanelView view(94, 64, options);
  const GrayCodePatterns patterns{94, 64, 8};
  const ScreenMap map = Decoded(patterns, Taken(view, patterns));
  const Vector2d last = view.ImageFromPanel({91, 32.5});
  const int x = static_cast<int>(last.x()), y = static_cast<int>(last.y());
  ASSERT_EQ(map.valid(x, y), 1);
  EXPECT_EQ(map.u_px(x, y), 91);
  EXPECT_EQ(map.v_px(x, y), 36);
  EXPECT_NEAR(map.sigma_u(x, y), 6 / std::sqrt(12.0), 1e-6);
  EXPECT_NEAR(map.sigma_v(x, y), 8 / std::sqrt(12.0), 1e-6);
}

// Of every bit of the column: whatever the way the screen is turned, in the camera's picture.
TEST(ShareOfStepsBack, TellsABitFromItsInverse) {
  for (const double roll_deg : {5.0, 95.0}) {
    PanelViewOptions options;
    options.width_px = options.height_px = 160;
    options.roll_deg = roll_deg;
    const PanelView view(128, 128, options);
    const GrayCodePatterns patterns{128, 128, 4};
    std::vector<Image<float>> photos = Taken(view, patterns);
    EXPECT_LT(ShareOfStepsBack(Decoded(patterns, photos)), 0.01);
    for (std::size_t bit = 0; bit < 5; ++bit) {
      const std::size_t i = 2 * (4 - bit);
      std::swap(photos[i], photos[i + 1]);
      // The most significant one, of 32 cells, mirrors the whole.
      EXPECT_NEAR(ShareOfStepsBack(Decoded(patterns, photos)),
                  bit < 4 ? std::pow(0.5, static_cast<double>(bit)) : 0, 0.1)
          << bit;
      std::swap(photos[i], photos[i + 1]);
    }
  }
}

TEST(DecodeGrayCode, RefusesWhatIsNotWhole) {
  const GrayCodePatterns patterns{64, 64, 8};
  const auto decode = [&](std::size_t odd) {
    DecodeGrayCode(patterns, [&](std::size_t i) { return Image<float>(i == odd ? 5 : 20, 20); });
  };
  EXPECT_NO_THROW(decode(100));
  for (const std::size_t odd : {0U, 3U, 12U, 13U}) {
    try {
      decode(odd);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("has photographs of different sizes"));
    }
  }
  EXPECT_THROW(DecodeGrayCode({}, [](std::size_t) { return Image<float>(20, 20); }), Error);
}

}  // namespace
}  // namespace lamella
