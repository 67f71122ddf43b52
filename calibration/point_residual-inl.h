// Residuals of observed points as Ceres takes them, for all models of a photograph. Include it in
// .cc files only, as all of Ceres.
#pragma once

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <ceres/loss_function.h>

#include "calibration/model.h"

namespace lamella {

// Of a point that its camera can't see: far beyond any outlier, without a slope.
inline constexpr double kUnseenResidual = 1e6;

template <class T>
bool Usable(const model::Vec2<T>& pixel) {
  const Eigen::Vector2d value(model::ValueOf(pixel.x()), model::ValueOf(pixel.y()));
  return value.allFinite() && value.cwiseAbs().maxCoeff() < 1e8;
}

// The numbers of a parameter block.
template <class T, int N>
Eigen::Matrix<T, N, 1> Numbers(const T* from) {
  return Eigen::Map<const Eigen::Matrix<T, N, 1>>(from);
}

template <class T>
model::Mat3<T> RotationOf(const T* xyzw) {
  return Eigen::Map<const Eigen::Quaternion<T>>(xyzw).toRotationMatrix();
}

// Where a photograph shows a point, ready to be compared with.
struct WhitenedPixel {
  WhitenedPixel(const Eigen::Vector2d& pixel, const Eigen::Matrix2d& covariance)
      : image_px(pixel), whitening(Eigen::Matrix2d(covariance.inverse()).llt().matrixU()) {}
  Eigen::Vector2d image_px;
  Eigen::Matrix2d whitening;  // L^T with L L^T the covariance's inverse
};

// L^T (predicted - measured).
template <class T>
void SetResidual(const WhitenedPixel& seen, const model::Vec2<T>& predicted, T* residual) {
  if (Usable(predicted)) {
    const T x = predicted.x() - seen.image_px.x(), y = predicted.y() - seen.image_px.y();
    residual[0] = seen.whitening(0, 0) * x + seen.whitening(0, 1) * y;
    residual[1] = seen.whitening(1, 1) * y;
  } else {
    residual[0] = T(kUnseenResidual);
    residual[1] = T(0.0);
  }
}

// Ceres applies a loss to a block's residuals together; this is for the two of a point, as Ceres
// would for a block: both are scaled by the root of the loss's slope, which gives its gradient and
// the Hessian of reweighted least squares. What the scaled square lacks of the loss is added up.
inline double ScaleOfLoss(const ceres::LossFunction* loss, const Eigen::Vector2d& residual,
                          double& lacking) {
  if (loss == nullptr) return 1;
  double rho[3];
  loss->Evaluate(residual.squaredNorm(), rho);
  lacking += rho[0] - rho[1] * residual.squaredNorm();
  return std::sqrt(rho[1]);
}

template <class T>
double ApplyLoss(const ceres::LossFunction& loss, T* r) {
  double lacking = 0;
  const double scale = ScaleOfLoss(&loss, {model::ValueOf(r[0]), model::ValueOf(r[1])}, lacking);
  r[0] *= T(scale);
  r[1] *= T(scale);
  return lacking;
}

}  // namespace lamella
