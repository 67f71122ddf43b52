#include "calibration/color_match.h"

#include <algorithm>
#include <random>
#include <string>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

Matrix3d Panel(double red, double green, double blue, double mixing) {
  Matrix3d m;
  m << 1, mixing, 0, mixing, 1, mixing, 0, mixing / 2, 1;
  return m * Vector3d(red, green, blue).asDiagonal();
}

// The largest multiple of a direction that a panel can show.
double Reach(const Matrix3d& camera_from_panel, const Vector3d& direction) {
  const Vector3d drive = camera_from_panel.inverse() * direction;
  return drive.minCoeff() < 0 ? 0 : 1 / drive.maxCoeff();
}

TEST(BrightestCommonWhite, IsTheLeastOfEachChannelWherePrimariesAgree) {
  const Vector3d white =
      BrightestCommonWhite({Panel(0.9, 0.6, 0.5, 0), Panel(0.5, 0.8, 0.7, 0)}, "d");
  EXPECT_LT((white - Vector3d(0.5, 0.6, 0.5)).norm(), 1e-12);
}

TEST(BrightestCommonWhite, HasNoBrighterLightInAllGamuts) {
  const std::vector<Matrix3d> panels = {Panel(0.9, 0.6, 0.5, 0.05), Panel(0.5, 0.8, 0.7, 0.12),
                                        Panel(0.7, 0.7, 0.9, 0.2)};
  const Vector3d white = BrightestCommonWhite(panels, "d");
  for (const Matrix3d& panel : panels) EXPECT_GE(Reach(panel, white), 1 - 1e-9);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const Vector3d direction(share(random), share(random), share(random));
    double reach = 1e9;
    for (const Matrix3d& panel : panels) reach = std::min(reach, Reach(panel, direction));
    EXPECT_LE(reach * direction.sum(), white.sum() + 1e-9);
  }
}

TEST(MatchColors, SharesTheCommonWhite) {
  // A camera that is not balanced: its red is weak.
  const Matrix3d camera = Vector3d(0.4, 1, 0.8).asDiagonal();
  const std::vector<Matrix3d> panels = {camera * Panel(0.5, 0.55, 0.45, 0.05),
                                        camera * Panel(0.4, 0.42, 0.45, 0.1)};
  const std::vector<LayerColors> layers = MatchColors(panels, "d");
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_NEAR(layers[0].gain + layers[1].gain, 1, 1e-12);
  // What both show of grey: alike, and at least one channel of one layer is fully on.
  double most = 0;
  const Vector3d common = BrightestCommonWhite(panels, "d");
  const Matrix3d viewer_from_camera = layers[0].gain * layers[0].primaries * panels[0].inverse();
  const Vector3d grey = viewer_from_camera * common;
  EXPECT_NEAR(grey.x(), grey.y(), 1e-9);
  EXPECT_NEAR(grey.x(), grey.z(), 1e-9);
  for (std::size_t l = 0; l < 2; ++l) {
    const Matrix3d viewer = layers[l].gain * layers[l].primaries;
    EXPECT_LT((viewer * panels[l].inverse() - viewer_from_camera).norm(), 1e-9);
    most = std::max(most, (viewer.inverse() * grey).maxCoeff());
    const Vector3d white = layers[l].primaries.rowwise().sum();
    EXPECT_NEAR(0.2126 * white.x() + 0.7152 * white.y() + 0.0722 * white.z(), 1, 1e-9);
  }
  EXPECT_NEAR(most, 1, 1e-9);
}

TEST(MatchColors, RefusesWhatCannotBeMatched) {
  const auto refusal = [](const std::vector<Matrix3d>& panels) {
    try {
      MatchColors(panels, "desk");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal({Panel(1, 1, 1, 0), Matrix3d::Ones()}),
              HasSubstr("desk: red, green and blue of layer 1 look alike"));
}

}  // namespace
}  // namespace lamella
