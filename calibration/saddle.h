// Corners of chessboard patterns to hundredths of a pixel, with their covariance.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

struct Saddle {
  Eigen::Vector2d position_px;     // the first pixel's centre is (0.5, 0.5)
  Eigen::Matrix2d covariance_px2;  // calibration.md section 4
};

// Standard deviation of white noise in a picture of edges and flat parts: the median of a second
// difference that vanishes on both (Immerkaer 1996, with a median), at least that of 8-bit codes.
double EstimateNoise(ImageSpan<const float> image);

// The point c that every gradient g near it points across, sum w g g^T (x - c) = 0 (Foerstner and
// Guelch 1987), w a Gaussian that falls to 1/e at `half_window` px and is cut there. `image` holds
// grey numbers of any monotone response; `noise` is their standard deviation. Nothing where the
// window leaves the image, holds no two directions of edges, or c runs out of the first window.
std::optional<Saddle> RefineSaddle(ImageSpan<const float> image, const Eigen::Vector2d& start_px,
                                   int half_window, double noise);

}  // namespace lamella
