#include "pipeline/preview_eyes.h"

#include <cmath>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

View Looking(const Eigen::Vector3d& centre, double cx = 256, double cy = 256) {
  View view;
  view.camera = {CameraModel::kPinhole, 512, 512, 600, 600, cx, cy, {}};
  view.camera_from_world.translation = -centre;
  return view;
}

struct Set {
  Display display = FindDisplay("paper-two-layer");
  Placement placement;
  explicit Set(const View& reference, double mm_per_view_px) {
    PlacementOptions options;
    options.mm_per_view_px = mm_per_view_px;
    options.depth_budget_mm = 20;
    placement = Place(reference, 8, 12, display, options, nullptr);
  }
};

TEST(EyeGrid, IsSymmetricWithTheHighestRowFirst) {
  PreviewOptions options;
  const auto eyes = EyeGrid(options);
  ASSERT_EQ(eyes.size(), 49U);
  EXPECT_EQ(eyes[24], Eigen::Vector2d(0, 0));
  EXPECT_EQ(eyes[0], Eigen::Vector2d(-54.3, 54.3));
  EXPECT_EQ(eyes[48], Eigen::Vector2d(54.3, -54.3));
  EXPECT_NEAR(eyes[25].x(), 18.1, 1e-12);
  options.positions = 1;
  EXPECT_EQ(EyeGrid(options)[0], Eigen::Vector2d(0, 0));
}

TEST(FocusPlanes, GoFromTheBackmostLayerToTheFrontmost) {
  const Display two = FindDisplay("paper-two-layer");
  const double back = two.layers[0].position_mm, front = two.layers[1].position_mm;
  ASSERT_LT(back, front);
  EXPECT_EQ(FocusPlanes(two, 3), (std::vector<double>{back, (back + front) / 2, front}));
  EXPECT_EQ(FocusPlanes(two, 1), std::vector<double>{(back + front) / 2});
  EXPECT_TRUE(FocusPlanes(two, 0).empty());
}

TEST(FocusedOn, KeepsTheLinesOfSight) {
  Eye eye;
  eye.position = {20, -10, 600};
  eye.left_mm = -50;
  eye.top_mm = 40;
  eye.pixel_mm = 0.5;
  const Eye focused = FocusedOn(eye, 150);  // a quarter of the way to the eye
  EXPECT_DOUBLE_EQ(focused.plane_mm, 150);
  EXPECT_DOUBLE_EQ(focused.left_mm, -50 + 0.25 * 70);
  EXPECT_DOUBLE_EQ(focused.top_mm, 40 - 0.25 * 50);
  EXPECT_DOUBLE_EQ(focused.pixel_mm, 0.375);
}

TEST(ParseEyes, ReadsPairsAndRefusesAnythingElse) {
  const auto eyes = ParseEyes("0,0; -27.15 , 3;1e1,-2");
  ASSERT_EQ(eyes.size(), 3U);
  EXPECT_EQ(eyes[1], Eigen::Vector2d(-27.15, 3));
  EXPECT_EQ(eyes[2], Eigen::Vector2d(10, -2));
  EXPECT_TRUE(ParseEyes("").empty());
  for (const char* wrong : {"1", "1,", "1,2,3", "a,b", "1;2", "1,2;;3,4", "1,2x", "inf,0"}) {
    EXPECT_THROW(ParseEyes(wrong), Error) << wrong;
  }
}

TEST(CentralEye, HasOnePixelPerViewPixelWhereThePlacementHasOnePerPanelPixel) {
  const View reference = Looking({0, 0, 0});
  const Set set(reference, FindDisplay("paper-two-layer").pitch_mm);
  const Eye eye = CentralEye(set.display, set.placement, reference, {});
  EXPECT_EQ(eye.width, 512);
  EXPECT_EQ(eye.height, 512);
  EXPECT_DOUBLE_EQ(eye.pixel_mm, set.display.pitch_mm);
  EXPECT_NEAR(eye.left_mm, -256 * set.display.pitch_mm, 1e-9);
  EXPECT_NEAR(eye.top_mm, 256 * set.display.pitch_mm, 1e-9);
  EXPECT_EQ(eye.position, Eigen::Vector3d(0, 0, 600));
}

TEST(CentralEye, IsCutToThePanelAndToTheWidth) {
  const View reference = Looking({0, 0, 0});
  const Set set(reference, 1.5);  // 768 mm: larger than the panel of 597.7 x 336.2 mm
  PreviewOptions options;
  options.width_px = 640;
  Eye eye = CentralEye(set.display, set.placement, reference, options);
  EXPECT_LE(eye.width, 640);
  EXPECT_GE(eye.width, 638);
  EXPECT_GE(eye.left_mm, -set.display.width_mm() / 2 - 1e-5);
  EXPECT_LE(eye.top_mm, set.display.height_mm() / 2 + 1e-5);
  EXPECT_LE(eye.height * eye.pixel_mm, set.display.height_mm() + 1e-5);
  options.eye_pixel_mm = 2.5;
  eye = CentralEye(set.display, set.placement, reference, options);
  EXPECT_EQ(eye.pixel_mm, 2.5);
  EXPECT_GE(eye.width, 237);
  options.eye_pixel_mm = 500;
  EXPECT_THROW(CentralEye(set.display, set.placement, reference, options), Error);
}

TEST(CapturedEyes, AreTheCamerasThatStandAtAnEyeWithTheirOwnPixels) {
  const View reference = Looking({0, 0, 0});
  const Set set(reference, 0.3);
  const Placement& p = set.placement;
  // A camera at X is the eye x = k f X / a with k = mm_per_view_px / D.
  const double world_per_mm = p.a / (p.mm_per_view_px / p.viewing_distance_mm * p.focal_px);
  std::vector<View> views = {reference, Looking({27.15 * world_per_mm, 0, 0}),
                             Looking({0, 27.15 * world_per_mm, 0}), Looking({0.3, 0, 0}),
                             Looking({0, 0, 0.1})};
  View turned = reference;
  turned.camera_from_world.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ());
  views.push_back(turned);
  const auto eyes =
      CapturedEyes(views, p, set.display, {{0, 0}, {27.15, 0}, {0, -27.15}}, p.mm_per_view_px);
  ASSERT_EQ(eyes.size(), 3U);
  EXPECT_EQ(eyes[0].view, 0);
  EXPECT_EQ(eyes[1].view, 1);
  EXPECT_NEAR(eyes[1].eye.position.x(), 27.15, 1e-9);
  // The world's y runs down, the display's up.
  EXPECT_EQ(eyes[2].view, 2);
  EXPECT_NEAR(eyes[2].eye.position.y(), -27.15, 1e-9);
  for (const CapturedEye& captured : eyes) {
    EXPECT_EQ(captured.shrink, 1);
    EXPECT_EQ(captured.pixels, (Rect{0, 0, 512, 512}));
    EXPECT_NEAR(captured.eye.pixel_mm, 0.3, 1e-9);
  }
  // A point of the plane z = 0 is at one place for all eyes: the middle pixel of the reference view
  // sees depth Z0 there, the view at X sees it f X / Z0 px further left.
  const double z0 = p.a * 600 / (1 - p.b * 600);  // of Z' = D
  EXPECT_NEAR(p.ZFromDepth(z0), 0, 1e-9);
  const double shift_px = 600 * 27.15 * world_per_mm / z0;
  EXPECT_NEAR(eyes[1].eye.left_mm, -256 * 0.3 + shift_px * 0.3, 1e-9);
}

TEST(CapturedEyes, ShrinkLargePhotographsByWholePixels) {
  const View reference = Looking({0, 0, 0});
  const Set set(reference, 0.1);
  const auto eyes = CapturedEyes({reference}, set.placement, set.display, {{0, 0}}, 0.3113);
  ASSERT_EQ(eyes.size(), 1U);
  EXPECT_EQ(eyes[0].shrink, 3);
  EXPECT_EQ(eyes[0].eye.width, 170);
  EXPECT_EQ(eyes[0].pixels.width, 510);
  EXPECT_NEAR(eyes[0].eye.pixel_mm, 0.3, 1e-9);
}

}  // namespace
}  // namespace lamella
