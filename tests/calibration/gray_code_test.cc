#include "calibration/gray_code.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

struct Photographs {
  std::vector<Image<float>> images;
  GrayCodeCapture capture;
};

Photographs Taken(const PanelView& view, int width, int height, int cell) {
  Photographs photos;
  photos.capture = {{}, width, height, cell};
  for (std::size_t i = 0; i < photos.capture.NumPhotos(); ++i) {
    const Image<Rgb8> pattern = DrawGrayCode(photos.capture, i);
    photos.images.push_back(
        Exposed(view.Photograph(pattern.span()).span(), {}, static_cast<std::uint32_t>(i + 1)));
  }
  for (const Image<float>& image : photos.images) photos.capture.photos.push_back(image.span());
  return photos;
}

// OpenCV: 42 images for a projector of 1024 x 768.
TEST(GrayCode, NeedsAsManyPhotographsAsOpenCvTakes) {
  EXPECT_EQ((GrayCodeCapture{{}, 1024, 768, 1}).NumPhotos(), 42U);
  EXPECT_EQ((GrayCodeCapture{{}, 1920, 1080, 8}).NumPhotos(), 2U * (8 + 8 + 1));
}

TEST(GrayCode, HasStripesByHand) {
  const GrayCodeCapture capture{{}, 8, 2, 1};
  const auto row = [&](std::size_t photo) {
    const Image<Rgb8> image = DrawGrayCode(capture, photo);
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
  const Photographs photos = Taken(view, 1000, 700, 1);
  const ScreenMap map = DecodeGrayCode(photos.capture);
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

TEST(DecodeGrayCode, RefusesWhatIsNotWhole) {
  PanelViewOptions options;
  options.width_px = options.height_px = 20;
  Photographs photos = Taken(PanelView(64, 64, options), 64, 64, 8);
  photos.capture.photos.pop_back();
  try {
    DecodeGrayCode(photos.capture);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("has 13 photographs; 64 x 64 px in cells of 8 need 14"));
  }
  photos.capture.photos.push_back(photos.images[0].span().Sub({0, 0, 5, 5}));
  EXPECT_THROW(DecodeGrayCode(photos.capture), Error);
  EXPECT_THROW(DecodeGrayCode({}), Error);
}

}  // namespace
}  // namespace lamella
