// Corners of chessboard patterns to hundredths of a pixel, with their covariance.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "calibration/noise_curve.h"
#include "lightfield/image.h"

namespace lamella {

struct Saddle {
  Eigen::Vector2d position_px;     // the first pixel's centre is (0.5, 0.5)
  Eigen::Matrix2d covariance_px2;  // of the noise, to first order
};

// The point c that every gradient g near it points across, sum w g g^T (x - c) = 0 (Foerstner and
// Guelch 1987), w = (1 - x^2/h^2)(1 - y^2/h^2) within h = `half_window` px. `image` holds grey
// numbers of any monotone response, `noise` their variance. Nothing where the window leaves the
// image, holds no two directions of edges, or c runs out of the first window.
std::optional<Saddle> RefineSaddle(ImageSpan<const float> image, const Eigen::Vector2d& start_px,
                                   int half_window, const NoiseCurve& noise);

}  // namespace lamella
