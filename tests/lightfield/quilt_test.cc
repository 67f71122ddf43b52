#include "lightfield/quilt.h"

#include <gtest/gtest.h>

#include "lightfield/published_quilts.h"

namespace lamella {
namespace {

void ExpectLayout(const char* name, int columns, int rows, std::optional<double> aspect) {
  SCOPED_TRACE(name);
  const std::optional<QuiltLayout> layout = QuiltLayoutOf(name);
  ASSERT_TRUE(layout);
  EXPECT_EQ(layout->columns, columns);
  EXPECT_EQ(layout->rows, rows);
  EXPECT_EQ(layout->aspect, aspect);
}

TEST(QuiltName, TellsTheLayout) {
  ExpectLayout("GreenBuddha_qs7x5a0.5625.jpg", 7, 5, 0.5625);
  ExpectLayout("quilt_numbers_qs8x6.png", 8, 6, std::nullopt);
  ExpectLayout("a_qs5x9a1.png", 5, 9, 1.0);
  ExpectLayout("a_qs5x9a1.777", 5, 9, 1.777);               // no extension
  ExpectLayout("a_qs5x9a1.777.v2.png", 5, 9, 1.777);        // the number ends at a second point
  ExpectLayout("of_qs5x9a1.6_qs8x6a0.75.png", 8, 6, 0.75);  // the last one
  ExpectLayout("a_qs8x6a0.75_qsfinal.png", 8, 6, 0.75);     // the last that is one
  ExpectLayout("a_qs8x6a0.75 (copy).png", 8, 6, 0.75);
  ExpectLayout("a_qs8x6around.png", 8, 6, std::nullopt);
}

TEST(QuiltName, WithoutALayoutTellsNone) {
  for (const char* name :
       {"", "a.png", "a_qs.png", "a_qs8.png", "a_qs8x.png", "a_qsx6.png", "a_qs0x6a1.png",
        "a_qs8x6a0.png", "a_qs8x99999999999a1.png", "a_qs-8x6a1.png", "a_QS8x6a1.png"}) {
    EXPECT_FALSE(QuiltLayoutOf(name)) << name;
  }
}

TEST(QuiltName, IsPrintedAsItIsRead) {
  EXPECT_EQ(QuiltSuffix({8, 6, 0.75}), "_qs8x6a0.75");
  EXPECT_EQ(QuiltSuffix({7, 5, 0.5625}), "_qs7x5a0.5625");
  EXPECT_EQ(QuiltSuffix({5, 9, 16.0 / 9}), "_qs5x9a1.7778");
  EXPECT_EQ(QuiltSuffix({8, 6, std::nullopt}), "_qs8x6");
  const std::optional<QuiltLayout> again = QuiltLayoutOf(QuiltSuffix({11, 6, 0.5625}) + ".png");
  ASSERT_TRUE(again);
  EXPECT_EQ(again->aspect, 0.5625);
}

// 3 x 2 tiles of 2 x 1 px in 7 x 3: a column is left over at the right, a row at the top.
TEST(Quilt, BeginsAtTheBottomLeftAndLeavesTheRestAtTheTopAndTheRight) {
  Image<Rgb8> quilt(7, 3);
  const QuiltLayout layout{3, 2, 1.0};
  for (int view = 0; view < 5; ++view) {
    const auto code = static_cast<std::uint8_t>(10 * (view + 1));
    Image<Rgb8> picture(2, 1, {code, code, code});
    picture(1, 0).b = 200;
    PutQuiltView(quilt.span(), layout, view, picture.span());
  }
  const int expected[3][7] = {
      {0, 0, 0, 0, 0, 0, 0}, {40, 40, 50, 50, 0, 0, 0}, {10, 10, 20, 20, 30, 30, 0}};
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 7; ++x) EXPECT_EQ(quilt(x, y).r, expected[y][x]) << x << "," << y;
  }
  EXPECT_EQ(QuiltView(quilt.span(), layout, 3)(0, 0), (Rgb8{40, 40, 40}));
  EXPECT_EQ(QuiltView(quilt.span(), layout, 3)(1, 0), (Rgb8{40, 40, 200}));
  EXPECT_EQ(QuiltViews(quilt.span(), layout), 5);
}

TEST(Quilt, CountsViewsUpToTheLastBlackOnes) {
  const QuiltLayout layout{2, 2, 1.0};
  Image<Rgb8> quilt(20, 20);
  EXPECT_EQ(QuiltViews(quilt.span(), layout), 0);
  quilt(15, 5) = {90, 90, 90};  // noise of a lossy file in the last tile
  EXPECT_EQ(QuiltViews(quilt.span(), layout), 0);
  PutQuiltView(quilt.span(), layout, 2, Image<Rgb8>(10, 10, {1, 1, 1}).span());
  EXPECT_EQ(QuiltViews(quilt.span(), layout), 3);  // black views before a lit one are views
}

// Through the camera and the middle of every pixel of the screen, seen from the front.
TEST(QuiltRays, GoFromTheCameraThroughTheScreensPixels) {
  QuiltCameras cameras;
  cameras.views = 5;
  const RayBundle rays = QuiltRays(cameras, 4, 3, 2);
  const Ray top_left = rays.RayAt(0.5, 0.5), bottom_right = rays.RayAt(2.5, 1.5);
  const QuiltCamera camera = CameraOf(cameras, 4);
  EXPECT_GT(camera.x, 0);
  EXPECT_EQ(top_left.origin, Eigen::Vector3d(camera.x, 0, camera.distance));
  EXPECT_TRUE((top_left.origin + top_left.direction).isApprox(Eigen::Vector3d(-40, 40, 0), 1e-9));
  EXPECT_TRUE(
      (bottom_right.origin + bottom_right.direction).isApprox(Eigen::Vector3d(40, -40, 0), 1e-9));
  EXPECT_TRUE(rays.Normal().isApprox(Eigen::Vector3d(0, 0, 1)));  // towards the viewer
}

// displays.md section 4.
TEST(PublishedQuilt, IsTheDevices) {
  const auto expect = [](const char* serial, bool upright, int columns, int rows, int width) {
    const PublishedQuilt quilt = PublishedQuiltFor(serial, upright);
    EXPECT_EQ(quilt.columns, columns) << serial;
    EXPECT_EQ(quilt.rows, rows) << serial;
    EXPECT_EQ(quilt.width_px, width) << serial;
  };
  expect("LKG-PORT-05935", true, 8, 6, 3360);
  expect("LKG-J00133", false, 7, 7, 5999);
  expect("LKG-2K-01234", false, 5, 9, 4096);
  expect("LKG-E01234", true, 11, 6, 4092);
  expect("my-own", true, 8, 6, 3360);
  expect("", false, 5, 9, 4096);
}

}  // namespace
}  // namespace lamella
