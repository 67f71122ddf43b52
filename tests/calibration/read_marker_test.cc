#include "calibration/read_marker.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr int kModule = 5, kLeft = 30, kTop = 20;

// By the obvious loops: black border, white around; `flipped` modules are wrong.
Image<float> Picture(int id, MarkerBits flipped, float black, float white) {
  Image<float> picture(100, 90, white);
  for (int v = 0; v < kMarkerSideModules * kModule; ++v) {
    for (int u = 0; u < kMarkerSideModules * kModule; ++u) {
      const int i = u / kModule - 1, j = v / kModule - 1;
      const bool inside = i >= 0 && j >= 0 && i < kMarkerModules && j < kMarkerModules;
      const bool lit =
          inside && ((BitsOfMarker(id) ^ flipped) >> (i + kMarkerModules * j) & 1U) != 0;
      picture(kLeft + u, kTop + v) = lit ? white : black;
    }
  }
  return picture;
}

Quad Place(double shift = 0) {
  const double side = kMarkerSideModules * kModule;
  const Vector2d at(kLeft + shift, kTop);
  return {at, at + Vector2d(side, 0), at + Vector2d(side, side), at + Vector2d(0, side)};
}

TEST(ShowsMarker, TellsOneFromAllOthers) {
  const Image<float> picture = Picture(77, 0, 0.1F, 0.9F);
  for (int id = 0; id < kNumMarkers; ++id) {
    EXPECT_EQ(ShowsMarker(picture.span(), Place(), id, 0.1), id == 77) << id;
  }
}

TEST(ShowsMarker, BearsTwoWrongModulesAndAThirdOfAModule) {
  EXPECT_TRUE(ShowsMarker(Picture(5, 0x100001, 0.1F, 0.9F).span(), Place(), 5, 0.1));
  EXPECT_FALSE(ShowsMarker(Picture(5, 0x100011, 0.1F, 0.9F).span(), Place(), 5, 0.1));
  EXPECT_TRUE(ShowsMarker(Picture(5, 0, 0.1F, 0.9F).span(), Place(kModule / 3.0), 5, 0.1));
  EXPECT_FALSE(ShowsMarker(Picture(5, 0, 0.1F, 0.9F).span(), Place(1.5 * kModule), 5, 0.1));
}

TEST(ShowsMarker, NeedsContrastAndTheWholeMarker) {
  EXPECT_FALSE(ShowsMarker(Picture(5, 0, 0.4F, 0.45F).span(), Place(), 5, 0.1));
  EXPECT_FALSE(ShowsMarker(Picture(5, 0, 0.9F, 0.1F).span(), Place(), 5, 0.1));  // inverted
  EXPECT_FALSE(ShowsMarker(Picture(5, 0, 0.1F, 0.9F).span(), Place(-kLeft - 2), 5, 0.1));
  EXPECT_FALSE(ShowsMarker(Image<float>(1, 1).span(), Place(), 5, 0.1));
}

TEST(ShowsMarker, KnowsReflectedMarkersByTheOrderOfTheirCorners) {
  const Image<float> picture = Picture(11, 0, 0.1F, 0.9F);
  Image<float> mirrored(picture.width(), picture.height());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      mirrored(x, y) = picture(picture.width() - 1 - x, y);
    }
  }
  Quad corners = Place();
  EXPECT_FALSE(ShowsMarker(mirrored.span(), corners, 11, 0.1));
  for (Vector2d& corner : corners) corner.x() = picture.width() - corner.x();
  EXPECT_TRUE(ShowsMarker(mirrored.span(), corners, 11, 0.1));
}

TEST(HomographyFromUnitSquare, TakesCornersToCorners) {
  const Quad quad = {Vector2d(10, 12), Vector2d(31, 9), Vector2d(36, 40), Vector2d(8, 33)};
  const Eigen::Matrix3d h = HomographyFromUnitSquare(quad);
  const Vector2d square[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_LT(((h * square[c].homogeneous()).hnormalized() - quad[c]).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace lamella
