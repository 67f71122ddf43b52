// The noise that was put into a photograph, dark and bright.
#include "calibration/noise_curve.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

// A board fills the middle of a dark photograph, 20 degrees rolled.
Image<float> LightOfABoard() {
  Image<Rgb8> board(640, 480);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      if ((u / 80 + v / 80) % 2 == 1) board(u, v) = {255, 255, 255};
    }
  }
  PanelViewOptions options;
  options.width_px = 1600;
  options.height_px = 800;
  options.roll_deg = 20;
  return PanelView(board.width(), board.height(), options).Photograph(board.span());
}

TEST(NoiseCurve, IsThatOfTheFlatParts) {
  const Image<float> light = LightOfABoard();
  for (const double sigma : {2.0 / 255, 8.0 / 255}) {
    const NoiseCurve noise(Exposed(light.span(), {0.1, 0.9, sigma, false}, 3).span());
    EXPECT_NEAR(noise.MedianDeviation() / sigma, 1, 0.05);
    for (const double grey : {0.0, 0.1, 0.5, 0.9, 1.0}) {
      EXPECT_NEAR(std::sqrt(noise.VarianceAt(grey)) / sigma, 1, 0.1) << grey;
    }
  }
}

TEST(NoiseCurve, GrowsWithLight) {
  const PhotoNoise put{0.05, 0.85, 2.0 / 255, false, 4e-4};
  const NoiseCurve noise(Exposed(LightOfABoard().span(), put, 3).span());
  EXPECT_NEAR(noise.MedianDeviation() * 255, 2, 0.3);  // the room is dark
  for (const double light : {0.0, 0.5, 1.0}) {
    const double sigma = std::sqrt(put.sigma * put.sigma + put.shot * light);
    EXPECT_NEAR(std::sqrt(noise.VarianceAt(0.05 + 0.8 * light)) / sigma, 1, 0.1) << light;
  }
}

TEST(NoiseCurve, IsNeverNone) {
  EXPECT_GT(NoiseCurve(Image<float>(10, 10, 0.5F).span()).VarianceAt(0.5), 1e-7);
  EXPECT_GT(NoiseCurve(Image<float>(100, 100, 0.5F).span()).VarianceAt(0.5), 1e-7);
  EXPECT_GT(NoiseCurve(Image<float>(1, 1).span()).VarianceAt(0), 1e-7);
}

}  // namespace
}  // namespace lamella
