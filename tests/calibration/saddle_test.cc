// Corners of rendered chessboards against the homography that they were rendered through.
#include "calibration/saddle.h"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr int kSquare = 80;

Image<Rgb8> Chessboard(int columns, int rows) {
  Image<Rgb8> board(columns * kSquare, rows * kSquare);
  for (int v = 0; v < board.height(); ++v) {
    for (int u = 0; u < board.width(); ++u) {
      if ((u / kSquare + v / kSquare) % 2 == 1) board(u, v) = {255, 255, 255};
    }
  }
  return board;
}

struct Errors {
  int count = 0;
  double rms = 0, normalised = 0;  // per axis; of e^T C^-1 e / 2
  Vector2d bias{0, 0};
};

// Every corner, refined from a start that is up to 2 px off.
Errors ErrorsOf(const PanelViewOptions& options, const PhotoNoise& noise, int half_window,
                int num_photos) {
  const Image<Rgb8> board = Chessboard(10, 8);
  const PanelView view(board.width(), board.height(), options);
  const Image<float> light = view.Photograph(board.span());
  Errors errors;
  for (int photo = 0; photo < num_photos; ++photo) {
    const Image<float> image = Exposed(light.span(), noise, static_cast<std::uint32_t>(photo + 1));
    const NoiseCurve curve(image.span());
    for (int j = 1; j < 8; ++j) {
      for (int i = 1; i < 10; ++i) {
        const Vector2d truth = view.ImageFromPanel({i * kSquare, j * kSquare});
        if (truth.x() < 15 || truth.y() < 15 || truth.x() > image.width() - 15 ||
            truth.y() > image.height() - 15) {
          continue;
        }
        const Vector2d start = truth + Vector2d((i * 7 % 5) - 2, (j * 3 % 5) - 2) * 0.9;
        const auto corner = RefineSaddle(image.span(), start, half_window, curve);
        if (!corner) {
          ADD_FAILURE() << "no corner at " << truth.transpose();
          continue;
        }
        const Vector2d error = corner->position_px - truth;
        errors.count += 1;
        errors.rms += error.squaredNorm() / 2;
        errors.bias += error;
        errors.normalised += error.dot(corner->covariance_px2.inverse() * error) / 2;
      }
    }
  }
  errors.rms = std::sqrt(errors.rms / errors.count);
  errors.bias /= errors.count;
  errors.normalised /= errors.count;
  return errors;
}

struct SaddleCase {
  double blur_px, roll_deg, yaw_deg, scale;
};

// calibration.md section 4: at most 0.05 px, bias under 0.01 px, up to a blur of 1.5 px.
TEST(RefineSaddle, IsWithinAFewHundredthsOfAPixel) {
  for (const SaddleCase& c :
       {SaddleCase{0.7, 3, 0, 1}, SaddleCase{1, 30, 20, 0.9}, SaddleCase{1.5, 90, -20, 1},
        SaddleCase{1.5, 45, 0, 1.1}, SaddleCase{0.7, 0, 15, 0.8}}) {
    PanelViewOptions options;
    options.blur_px = c.blur_px;
    options.roll_deg = c.roll_deg;
    options.yaw_deg = c.yaw_deg;
    options.scale = c.scale;
    const Errors errors = ErrorsOf(options, {}, 9, 2);
    const std::string where = "blur " + std::to_string(c.blur_px) + " roll " +
                              std::to_string(c.roll_deg) + ": rms " + std::to_string(errors.rms) +
                              " normalised " + std::to_string(errors.normalised);
    EXPECT_GT(errors.count, 40) << where;
    EXPECT_LT(errors.rms, 0.03) << where;
    EXPECT_LT(errors.bias.norm(), 0.01) << where << " bias " << errors.bias.transpose();
    EXPECT_GT(errors.normalised, 0.4) << where;
    EXPECT_LT(errors.normalised, 3) << where;
  }
}

// White noise; next to none, where what a corner's place between pixels does to it would show; and
// light's own noise, in a photograph that is dark for the most part.
TEST(RefineSaddle, KnowsItsCovariance) {
  for (const int half_window : {5, 13}) {
    for (const PhotoNoise& noise :
         {PhotoNoise{0.1, 0.9, 5.0 / 255, false}, PhotoNoise{0.1, 0.9, 1.0 / 255, true},
          PhotoNoise{0, 0.9, 0.5 / 255, true, 3e-4}}) {
      PanelViewOptions options;
      options.width_px = noise.shot > 0 ? 1800 : 640;
      options.roll_deg = 20;
      const Errors errors = ErrorsOf(options, noise, half_window, 6);
      const std::string where = "window " + std::to_string(half_window) + " noise " +
                                std::to_string(noise.sigma) + ": rms " +
                                std::to_string(errors.rms) + " normalised " +
                                std::to_string(errors.normalised);
      EXPECT_GT(errors.normalised, 0.8) << where;
      EXPECT_LT(errors.normalised, 1.25) << where;
    }
  }
}

TEST(RefineSaddle, FindsNothingWhereThereIsNoCorner) {
  Image<float> edge(60, 60, 0.1F);
  for (int y = 0; y < 60; ++y) {
    for (int x = 30; x < 60; ++x) edge(x, y) = 0.9F;
  }
  const NoiseCurve noise(edge.span());
  EXPECT_FALSE(RefineSaddle(edge.span(), {30, 30}, 9, noise));
  EXPECT_FALSE(RefineSaddle(Image<float>(60, 60, 0.5F).span(), {30, 30}, 9, noise));
  EXPECT_FALSE(RefineSaddle(edge.span(), {5, 30}, 9, noise));
  EXPECT_FALSE(RefineSaddle(Image<float>(1, 1).span(), {0.5, 0.5}, 9, noise));
}

}  // namespace
}  // namespace lamella
